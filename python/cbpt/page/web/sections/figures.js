/** 3. The figures of catalogues: of the readings, of the drive as stated, and with the answer. */

/** @import { Any } from "../types.d.ts" */
import { get, isLive } from "../lib/api.js";
import { bodyOf, el, fill, showSection, table } from "../lib/dom.js";
import { painted } from "../lib/figure.js";
import { text, withUncertainty } from "../lib/numbers.js";
import { documentShown, on, scale, state, tell } from "../lib/store.js";

/** What a buyer compares; all others stand with the table. */
const FIRST = ["lost_motion", "hysteresis_loss", "torsional_rigidity"];
/** The lowest setting, one in the middle and the highest are enough to see what changes. */
const MOST_SETTINGS = 3;

export function setUpFigures() {
  on(["document"], ask);
  on(["document", "unit", "table"], draw);
}

/** The workbench shows the answer first; the figures take a second or two more. */
async function ask() {
  const whole = documentShown();
  if (!isLive() || !whole.answer || whole.table) return;
  try {
    await painted();
    const found = await get("table");
    if (state.document !== whole) return;
    whole.table = found;
    tell("table");
  } catch {
    // Other files have been opened meanwhile, or the server has ended, which others tell.
  }
}

function draw() {
  const whole = documentShown();
  /** @type {Any[]} */
  const loops = whole.table?.loops ?? [];
  const coming = isLive() && whole.answer && !whole.table;
  showSection("figures", coming || loops.length > 0);
  if (coming) return fill(bodyOf("figures"), el("p", { class: "quiet" }, "The figures follow."));
  const kept = loops.length <= MOST_SETTINGS
    ? loops
    : [loops[0], loops[loops.length >> 1], loops[loops.length - 1]];
  const answered = kept.some(({ figures }) =>
    figures.some((/** @type {Any} */ f) => f.after !== null)
  );
  const rows = kept.flatMap(({ setting, figures }) =>
    figures.filter((/** @type {Any} */ f) => FIRST.includes(f.name) && isThere(f)).map((
      /** @type {Any} */ f,
    ) =>
      [
        [
          `${f.name.replaceAll("_", " ")} (${unitOf(f)})`,
          setting && el("div", { class: "small quiet" }, setting),
        ],
        shown(f, f.value, f.u),
        shown(f, f.model, f.u_model),
        answered && shown(f, f.after, f.u_after),
      ].filter((cell) => cell !== false)
    )
  );
  const missing = kept.some(({ figures }) =>
    figures.some((/** @type {Any} */ f) => FIRST.includes(f.name) && !isThere(f))
  );
  const more = loops.length > MOST_SETTINGS
    ? `${MOST_SETTINGS} of ${loops.length} settings; all figures stand with `
    : missing
    ? "Figures that these loops do not give stand, each with its reason, with "
    : null;
  fill(
    bodyOf("figures"),
    el(
      "div",
      { class: "card" },
      table(
        "Figures of catalogues before and after",
        [
          "figure",
          "readings",
          "drive as stated",
          answered && "with the answer",
        ].filter((head) => head !== false),
        rows,
      ),
      more &&
        el(
          "p",
          { class: "small quiet" },
          more,
          el("a", { href: "#table" }, "the table and its loops"),
          ".",
        ),
    ),
  );
}

/** Whether any of the columns has it. @param {Any} f */
function isThere(f) {
  return [f.value, f.model, f.after].some((v) => v !== null);
}

/** @param {Any} f */
export function unitOf(f) {
  return f.unit === "arcsec" ? state.unit : f.unit;
}

/** A figure with its uncertainty, in the unit shown. @param {Any} f @param {number | null} value @param {number | null} u */
export function shown(f, value, u) {
  if (value === null) return "–";
  const factor = f.unit === "arcsec" ? scale() : 1;
  return u ? withUncertainty(value * factor, u * factor) : text(value * factor);
}
