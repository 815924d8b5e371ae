/** 1. The sentence of the answer, how sure it is, what it rests on, the error before and after. */

/** @import { Child } from "../lib/page.d.ts" */
/** @import { PageDocument, RestsOn } from "../types.d.ts" */
import { isLive } from "../lib/api.js";
import { bar, bodyOf, byId, el, fill, svg } from "../lib/dom.js";
import { inPrint, nameOf, withCapital } from "../lib/names.js";
import { percent, probability, text } from "../lib/numbers.js";
import { show } from "../lib/models.js";
import { documentShown, modelOf, modelShown, on, setModel, size, state } from "../lib/store.js";

const KINDS = /** @type {Record<string, string>} */ ({
  effect: "the effect that is named is missing",
  parameter: "a number of the drive differs from its stated value",
  rig: "the instrument has an error",
  ambiguous: "these readings do not separate several explanations",
  unknown: "an effect outside the library is missing",
  complete: "nothing is missing",
  undecided: "these readings do not decide",
});
/** Kinds of answers that name something. */
const NAMED = ["effect", "parameter", "rig"];
// More notes than this are folded.
const MOST_NOTES = 3;

export function setUpAnswer() {
  on(["document", "unit"], draw);
  on(["model"], () => {
    const button = document.getElementById("show-answer");
    if (button) button.textContent = showsAnswer();
  });
}

function draw() {
  const whole = documentShown();
  document.title = `${whole.data.name} – CBPT`;
  fill(byId("product-version"), whole.product.version);
  fill(
    byId("what"),
    el("b", {}, whole.data.name),
    ` · ${whole.data.rows} readings against `,
    el("b", {}, whole.case.name),
  );
  fill(
    byId("foot"),
    el(
      "p",
      {},
      `CBPT ${whole.product.version}. Readings ${whole.data.sha256.slice(0, 16)}, case ${
        whole.case.sha256.slice(0, 16)
      } (SHA-256). Every number here is in the answer's JSON document.`,
    ),
  );
  fill(bodyOf("answer"), !isLive() && head(whole), whole.answer ? found(whole) : waiting(whole));
}

/** What the answer is held against first, in one sentence. @param {PageDocument} whole */
function nearest(whole) {
  const rival = whole.why[0];
  return rival && el(
    "p",
    { class: "small", id: "nearest" },
    el("b", {}, "Why this and not that. "),
    inPrint(rival.sentence[state.unit]),
    " ",
    el("a", { class: "no-print", href: "#why" }, "All rivals"),
  );
}

/** Of a report: what was measured, on what, by whom. @param {PageDocument} whole */
function head(whole) {
  const { drive, measured, rig, author, date } = whole.head;
  const file = (/** @type {string} */ name, /** @type {string} */ sha256) =>
    `${name} (SHA-256 ${sha256.slice(0, 12)})`;
  const rows = [
    ["Drive", drive],
    ["Rig", rig],
    ["Measured", measured],
    [
      "Files",
      `${file(whole.case.name, whole.case.sha256)}, ${file(whole.data.name, whole.data.sha256)}`,
    ],
    ["Report", [date, author && `by ${author}`].filter(Boolean).join(" ")],
  ];
  return el(
    "dl",
    { class: "head", id: "head" },
    rows.filter(([, said]) => said).map(([name, said]) =>
      el("div", {}, el("dt", {}, name), el("dd", {}, said))
    ),
  );
}

/** @param {PageDocument} whole */
function waiting(whole) {
  const stated = whole.models[0];
  return el(
    "div",
    { class: "card" },
    el(
      "p",
      { class: "sentence" },
      `The drive as stated leaves an error of ${size(stated.rmse_arcsec)} ${state.unit}, rms.`,
    ),
    el(
      "p",
      { class: "quiet" },
      whole.reasons.answer ?? "The readings have not been diagnosed yet.",
    ),
    notes(whole),
  );
}

function showsAnswer() {
  return modelShown().key === documentShown().answer_key
    ? "The plots show the model of the answer"
    : "Show the model of the answer";
}

/** @param {PageDocument} whole */
function found(whole) {
  const { verdict, before, after, noise } = whole.answer;
  // What does not explain the readings is no "after".
  const explained = whole.answer_key !== null;
  const moved = explained && before.rmse_arcsec !== after.rmse_arcsec;
  const best = (/** @type {number | null} */ v) =>
    explained || whole.undecided
      ? ""
      : `; the best library effect leaves ${size(v)} and does not explain the readings`;
  const floor = whole.noise.noise_floor_arcsec;
  const judged = whole.readings.used.filter(Boolean).length;
  const of = judged < whole.data.rows ? ` of the ${judged} readings judged` : "";
  const offsets = noise.run_offset_arcsec ? ", offsets of runs left out" : "";
  return el(
    "div",
    { class: "card" },
    el(
      "p",
      { class: "sentence", id: "sentence" },
      (whole.sentence[state.unit] ?? []).map((part) =>
        part.aside ? el("span", { class: "aside" }, part.text) : part.text
      ),
    ),
    el(
      "dl",
      { class: "facts" },
      !whole.undecided && fact(
        "Probability of this answer",
        probability(verdict.probability),
        `${KINDS[verdict.kind] ?? verdict.kind}${
          NAMED.includes(verdict.kind) ? "; other effects may act beside it" : ""
        }`,
        el("div", { class: "bar" }, bar(verdict.probability)),
      ),
      fact(
        whole.undecided
          ? "Probability of the most probable combination"
          : "Probability of exactly this combination",
        probability(verdict.probability_exactly),
        alone(whole.combinations[0]?.label ?? "no effect"),
        el("div", { class: "bar" }, bar(verdict.probability_exactly)),
      ),
      fact(
        moved ? "Error before → after" : explained ? "Error" : "Error as stated",
        moved
          ? `${size(before.rmse_arcsec)} → ${size(after.rmse_arcsec)}`
          : size(before.rmse_arcsec),
        `${state.unit}, in sample${of}${offsets}${best(after.rmse_arcsec)}`,
        explained && fall(before.rmse_arcsec, after.rmse_arcsec, floor),
      ),
      explained && fact(
        "Held-out error before → after",
        `${size(before.held_out_rmse_arcsec)} → ${size(after.held_out_rmse_arcsec)}`,
        `${state.unit}, by ${whole.answer.held_out_by}`,
        fall(before.held_out_rmse_arcsec, after.held_out_rmse_arcsec, floor),
      ),
      fact(
        "Noise floor",
        size(floor),
        floor === null
          ? whole.noise.noise_floor_of
          : `${state.unit}, ${whole.noise.noise_floor_of}${
            // Beside a misfit without a name that is not the noise of the floor.
            after.noise_floor_arcsec === null
              ? ""
              : `; noise model: ${noise.model.map(nameOf).join(", ")}`}`,
      ),
      fact(
        "χ² / dof",
        explained
          ? `${text(before.chi2_per_dof)} → ${text(after.chi2_per_dof)}`
          : text(before.chi2_per_dof),
        "noise alone gives 1",
      ),
    ),
    el(
      "div",
      { class: "stack" },
      nearest(whole),
      remains(whole),
      !whole.undecided && restsOn(whole.rests_on),
      notes(whole),
      el(
        "div",
        { class: "row no-print" },
        whole.answer_key && whole.answer_key !== "stated" && el(
          "button",
          {
            type: "button",
            class: "main",
            id: "show-answer",
            onclick: () => {
              const effects = whole.models.find((m) => m.key === whole.answer_key)?.effects ?? [];
              if (effects.length) show(effects);
              else if (whole.answer_key) setModel(whole.answer_key);
            },
          },
          showsAnswer(),
        ),
        !explained && modelOf("unknown") && el(
          "button",
          {
            type: "button",
            class: "main",
            id: "show-pattern",
            onclick: () => setModel("unknown"),
          },
          "Show the lack of fit as a free function",
        ),
        whole.own.draft && el("a", { href: "#own" }, "A draft of the missing term"),
        el("span", { class: "small quiet" }, whole.u_says[state.unit]),
      ),
    ),
  );
}

/** What is left after the answer, against what readings scatter by. @param {PageDocument} whole */
function remains(whole) {
  const rest = whole.remains;
  if (!rest) return null;
  const share = rest.share_of_misfit === null
    ? ""
    : `, ${percent(rest.share_of_misfit)} of the squared misfit`;
  const scatter = rest.expected_arcsec === null || rest.expected_from === null
    ? ""
    : `; readings scatter by ${size(rest.expected_arcsec)} ${state.unit} (${rest.expected_from})`;
  return el(
    "div",
    { id: "remains" },
    el("h2", { class: "minor" }, "What remains"),
    el(
      "p",
      { class: "small" },
      `A misfit of ${
        size(rest.rms_arcsec)
      } ${state.unit}, rms${share}, has no name. It depends on ${rest.depends_on}${scatter}.`,
    ),
  );
}

/** A combination, and that nothing acts beside it. */
function alone(/** @type {string} */ label) {
  return label === "no effect" ? label : `${label}, and nothing else`;
}

/** @param {string} name @param {string} value @param {string} more @param {Child} [picture] */
function fact(name, value, more, picture) {
  return el(
    "div",
    {},
    el("dt", {}, name),
    el("dd", {}, value, picture, el("small", {}, more)),
  );
}

/**
 * Two bars, of the error before and after, and the noise across them.
 * @param {number | null} before @param {number | null} after @param {number | null} floor
 */
function fall(before, after, floor) {
  if (before === null || after === null) return null;
  const most = Math.max(before, after);
  const across = (/** @type {number} */ v) => `${(100 * Math.min(1, v / most)).toFixed(1)}%`;
  const line = floor === null ? null : across(floor);
  return svg(
    "svg",
    { class: "fall", width: "100%", height: 18, "aria-hidden": "true" },
    svg("rect", { class: "was", width: across(before), y: 1, height: 6, rx: 2 }),
    svg("rect", { class: "is", width: across(after), y: 10, height: 6, rx: 2 }),
    line && svg("line", { class: "noise", x1: line, x2: line, y1: 0, y2: 18 }),
  );
}

/** @param {RestsOn[]} numbers */
function restsOn(numbers) {
  if (!numbers.length) {
    return el(
      "p",
      { class: "small quiet" },
      "The answer does not depend on the stated numbers: no error in one of them explains the same residual.",
    );
  }
  return el(
    "div",
    {},
    el("h2", { class: "minor" }, "What it rests on"),
    el(
      "ul",
      { class: "plain small" },
      numbers.map((r) =>
        el(
          "li",
          {},
          `${withCapital(r.label)}, stated with an uncertainty of ${r.prior}: an error of ${
            text(Math.abs(r.needed_shift_sigma), 2)
          } standard uncertainties in it${
            numbers.length > 1 ? ", together with errors in the others listed here," : ""
          } explains the same residual.`,
        )
      ),
    ),
  );
}

/** Many are folded; on paper they stand in the appendix. @param {PageDocument} whole */
function notes(whole) {
  const { notes } = whole.data;
  const list = () => el("ul", { class: "plain small quiet" }, notes.map((n) => el("li", {}, n)));
  const told = `${notes.length} notes on the readings`;
  if (notes.length <= MOST_NOTES) {
    fill(byId("notes"));
    return notes.length ? list() : null;
  }
  fill(byId("notes"), el("h2", {}, told), list());
  return el(
    "div",
    {},
    el("details", { class: "no-print" }, el("summary", {}, told), list()),
    el("p", { class: "small quiet paper-only" }, `${told} stand in the appendix.`),
  );
}
