/** 15. The data sheet of the drive, as `cbpt datasheet` writes it: made by the server when asked. */

import { isLive, post, Superseded } from "../lib/api.js";
import { announce, bodyOf, byId, el, fill, trouble } from "../lib/dom.js";
import { saveFile } from "../lib/figure.js";
import { documentShown, hasBalls, on } from "../lib/store.js";

/** Files whose sheet is shown. @type {number | undefined} */
let of;

export function setUpSheet() {
  on(["document"], () => {
    const shown = isLive() && hasBalls();
    byId("data-sheet").hidden = !shown;
    const entry = document.querySelector('.contents a[href="#data-sheet"]')?.parentElement;
    if (entry) entry.hidden = !shown;
    if (!shown || of === documentShown().opened) return;
    of = documentShown().opened;
    draw(null);
  });
}

/** @param {string | null} html the sheet; null before it is asked for */
function draw(html) {
  const name = documentShown().case.name.replace(/\.[^.]*$/, "").replace(/[^\w.-]+/g, "_") ||
    "drive";
  fill(
    bodyOf("data-sheet"),
    el(
      "div",
      { class: "card stack no-print" },
      el(
        "p",
        { class: "small quiet" },
        "One page of the drive at the load of the case, without effects: stiffness, friction, efficiency, preload window, pressures.",
      ),
      el(
        "div",
        { class: "row" },
        el("button", { type: "button", id: "make-sheet", onclick: make }, "Make the data sheet"),
        html !== null && el("button", {
          type: "button",
          id: "save-sheet",
          onclick: () => saveFile(`${name}_datasheet.html`, html, "text/html"),
        }, "Save (HTML)"),
      ),
      // Nothing in it may run; its styles are its own.
      html !== null && el("iframe", {
        class: "sheet",
        title: "Data sheet of the drive",
        sandbox: "",
        srcdoc: html,
      }),
    ),
  );
}

async function make() {
  const button = /** @type {HTMLButtonElement} */ (byId("make-sheet"));
  button.disabled = true;
  button.textContent = "The data sheet is being made";
  try {
    const { html } = await post("datasheet", {});
    trouble(null);
    draw(html);
    announce("The data sheet is shown");
  } catch (error) {
    if (error instanceof Superseded) return;
    draw(null);
    trouble(error instanceof Error ? error.message : String(error));
  }
}
