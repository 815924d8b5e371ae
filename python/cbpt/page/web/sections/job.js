/**
 * The diagnosis under way, in the workbench: it begins with the readings, tells how far it is, and
 * can be stopped. The readings stand beside the drive as stated meanwhile.
 */

/** @import { Child } from "../lib/page.d.ts" */
import { get, isLive, post, Superseded } from "../lib/api.js";
import { announce, byId, el, fill, trouble } from "../lib/dom.js";
import { on, setDocument, state } from "../lib/store.js";

const PAUSE_MS = 150;

export function setUpJob() {
  if (isLive()) on(["document"], look);
}

/** @param {unknown} error */
function told(error) {
  if (error instanceof Superseded) return;
  trouble(error instanceof Error ? error.message : String(error));
}

/** Whether the readings shown wait for an answer. */
function open() {
  return state.document !== null && state.document.answer === null;
}

/** Counts the documents: only the latest is begun and followed. */
let latest = 0;

/** A new document: begin, or go on with what has begun. */
async function look() {
  latest++;
  byId("job").hidden = !open();
  if (!open()) return;
  try {
    const job = await get("job");
    if (job.state === "idle") await begin();
    else if (job.state === "running" || job.state === "done") await follow();
    else offer();
  } catch (error) {
    told(error);
  }
}

/**
 * Other content for the place of the job, with one button: who has pressed the one before is on it.
 * @param {...Child} children
 */
function replace(...children) {
  const place = byId("job");
  const pressed = place.contains(document.activeElement);
  fill(place, ...children);
  if (pressed) place.querySelector("button")?.focus({ preventScroll: true });
}

/** Nothing more to do here: who is on its button goes on with the answer. */
function hide() {
  const place = byId("job");
  if (place.contains(document.activeElement)) byId("answer").focus({ preventScroll: true });
  place.hidden = true;
}

/** A button where nothing is under way. */
function offer() {
  replace(
    el(
      "button",
      { type: "button", class: "main", id: "diagnose", onclick: () => begin().catch(told) },
      "Which effect is missing?",
    ),
    el(
      "span",
      { class: "small quiet" },
      "Compares every effect of the library with the readings; this takes some seconds.",
    ),
  );
}

async function begin() {
  await post("diagnose", {});
  await follow();
}

/** The same readings again, with the effects of the user's own among those that compete. */
export async function diagnoseWithOwn() {
  try {
    latest++;
    await post("diagnose", { own: true });
    await follow();
  } catch (error) {
    told(error);
  }
}

/** Ask until it has ended. */
async function follow() {
  const mine = latest;
  let job = await get("job");
  for (; job.state === "running"; job = await get("job")) {
    if (mine !== latest) return;
    show(job);
    await new Promise((done) => setTimeout(done, PAUSE_MS));
  }
  if (mine !== latest) return;
  if (job.state === "done") {
    const answered = await get("document");
    if (mine !== latest) return;
    hide();
    setDocument(answered);
    announce("The diagnosis is done.");
    return;
  }
  if (job.state === "failed") trouble(job.error);
  offer();
}

/** @param {any} job */
function show(job) {
  const place = byId("job");
  place.hidden = false;
  if (!place.querySelector("progress")) {
    replace(
      el("span", { id: "job-stage", "aria-live": "polite" }),
      el("progress", { max: 1, "aria-label": "Diagnosis" }),
      el(
        "button",
        { type: "button", id: "cancel", onclick: () => post("cancel", {}).catch(told) },
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
