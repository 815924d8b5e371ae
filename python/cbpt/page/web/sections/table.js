/** 10. The table by itself: checks before any model, and the figures of its loops. */

/** @import { Any } from "../types.d.ts" */
import { bodyOf, el, fill, table } from "../lib/dom.js";
import { shown, unitOf } from "./figures.js";
import { documentShown, on } from "../lib/store.js";

/** @type {Record<string, string>} */
const STATES = { good: "good", look: "look again", lost: "cannot be told" };

export function setUpTable() {
  on(["document", "unit", "table"], draw);
}

function draw() {
  const found = documentShown().table;
  if (!found) {
    fill(
      bodyOf("table"),
      el(
        "p",
        { class: "quiet" },
        documentShown().answer
          ? "The checks and figures follow."
          : "The readings have not been diagnosed yet; cbpt preflight and cbpt characterise look at the table without a diagnosis.",
      ),
    );
    return;
  }
  const { checks, loops } = found;
  const rows = checks.map((
    /** @type {Any} */ c,
  ) => [c.subject, STATES[c.state], c.finding, c.remedy]);
  fill(
    bodyOf("table"),
    el(
      "div",
      { class: "grid" },
      el(
        "div",
        { class: "card", id: "preflight" },
        el("h3", {}, "Before any model"),
        table("Checks of the table", ["subject", "", "found", "on the rig"], rows),
      ),
      loops.map((/** @type {Any} */ { setting, figures, warnings }) =>
        el(
          "div",
          { class: "card loops" },
          el("h3", {}, setting ? `Figures of the loops, ${setting}` : "Figures of the loops"),
          table(
            "Figures of catalogues",
            ["figure", "readings", "drive as stated", "with the answer"],
            figures.map((/** @type {Any} */ f) => [
              [
                `${f.name.replaceAll("_", " ")} (${unitOf(f)})`,
                el("div", { class: "small quiet" }, f.convention),
              ],
              f.value === null ? `none: ${f.reason}` : shown(f, f.value, f.u),
              shown(f, f.model, f.u_model),
              shown(f, f.after, f.u_after),
            ]),
          ),
          warnings.map((/** @type {string} */ w) => el("p", { class: "small" }, w)),
        )
      ),
    ),
  );
}
