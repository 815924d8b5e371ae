/** The diagnosis under way, in the workbench: how far it is, and a way to stop it. */

import { get, isLive, post } from "./api.js";
import { announce, byId, el, fill, trouble } from "./dom.js";
import { on, setDocument, state } from "./store.js";

export function setUpJob() {
  on(["document"], draw);
}

let asking = false;

function draw() {
  const place = byId("job");
  if (!isLive() || asking) return;
  place.hidden = !state.document || state.document.answer !== null;
  if (place.hidden) return;
  fill(
    place,
    el("button", {
      type: "button",
      class: "main",
      id: "diagnose",
      onclick: () => diagnose(),
    }, "Which effect is missing?"),
    el(
      "span",
      { class: "small quiet" },
      "Weighs every effect of the library against the readings; takes some seconds.",
    ),
  );
}

/** Start a diagnosis, and follow it. */
export async function diagnose() {
  try {
    await post("diagnose", {});
    follow();
  } catch (error) {
    trouble(error instanceof Error ? error.message : String(error));
  }
}

/** Ask until it is done. */
export async function follow() {
  if (asking) return;
  asking = true;
  try {
    let job = await get("job");
    for (; job.state === "running"; job = await get("job")) {
      show(byId("job"), job);
      await new Promise((done) => setTimeout(done, 150));
    }
    asking = false;
    if (job.state === "failed") trouble(job.error);
    if (job.state === "done" && !state.document?.answer) {
      setDocument(await get("document"));
      announce("The diagnosis is done.");
    } else draw();
  } catch (error) {
    trouble(error instanceof Error ? error.message : String(error));
  } finally {
    asking = false;
  }
}

/** @param {HTMLElement} place @param {any} job */
function show(place, job) {
  place.hidden = false;
  if (!place.querySelector("progress")) {
    fill(
      place,
      el("span", { id: "job-stage", "aria-live": "polite" }),
      el("progress", { max: 1, "aria-label": "Diagnosis" }),
      el(
        "button",
        {
          type: "button",
          id: "cancel",
          onclick: () => post("cancel", {}).catch((error) => trouble(error.message)),
        },
        "Cancel",
      ),
    );
  }
  const stage = place.querySelector("#job-stage");
  const words = `${job.stage || "diagnosing"} …`;
  if (stage && stage.textContent !== words) stage.textContent = words;
  const bar = place.querySelector("progress");
  if (bar && job.share > 0) bar.value = job.share;
}
