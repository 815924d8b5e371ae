/** 1. The sentence of the answer, how sure it is, what it rests on, the error before and after. */

/** @import { PageDocument } from "./types.d.ts" */
import { bodyOf, byId, el, fill } from "./dom.js";
import { fixed, nameOf, probability, text } from "./numbers.js";
import { show } from "./models.js";
import { documentShown, on, scale, setModel, state } from "./store.js";

export function setUpAnswer() {
  on(["document", "unit"], draw);
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
  fill(bodyOf("answer"), whole.answer ? found(whole) : waiting(whole));
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
      `As stated, the model is ${fixed((stated.rmse_arcsec ?? 0) * scale(), 2)} ${state.unit} off.`,
    ),
    el(
      "p",
      { class: "quiet" },
      whole.reasons.answer ?? "Which effect is missing has not been asked yet.",
    ),
    notes(whole),
  );
}

/** @param {PageDocument} whole */
function found(whole) {
  const { verdict, before, after, noise } = whole.answer;
  const size = (/** @type {number | null} */ v) => (v === null ? "–" : fixed(v * scale(), 2));
  const moved = before.rmse_arcsec !== after.rmse_arcsec;
  return el(
    "div",
    { class: "card" },
    el("p", { class: "sentence", id: "sentence" }, verdict.sentence.replaceAll("+-", "±")),
    el(
      "dl",
      { class: "facts" },
      fact("Probability", probability(verdict.probability), `kind of answer: ${verdict.kind}`),
      fact(
        moved ? "Error before → after" : "Error",
        moved
          ? `${size(before.rmse_arcsec)} → ${size(after.rmse_arcsec)}`
          : size(before.rmse_arcsec),
        `${state.unit}, in sample`,
      ),
      fact(
        "Held out before → after",
        `${size(before.held_out_rmse_arcsec)} → ${size(after.held_out_rmse_arcsec)}`,
        `${state.unit}, by ${whole.answer.held_out_by}`,
      ),
      fact(
        "Noise floor",
        size(whole.noise.noise_floor_arcsec),
        whole.noise.noise_floor_arcsec === null
          ? whole.noise.noise_floor_of
          : `${state.unit}, ${whole.noise.noise_floor_of}; ${noise.model.map(nameOf).join(", ")}`,
      ),
      fact(
        "χ² per degree of freedom",
        `${text(before.chi2_per_dof)} → ${text(after.chi2_per_dof)}`,
        "1 is what noise alone leaves",
      ),
    ),
    el(
      "div",
      { class: "stack", style: null },
      restsOn(verdict.rests_on),
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
          "Show the model of the answer",
        ),
        whole.own.draft && el("a", { href: "#own" }, "A first draft of the missing term"),
        el("span", { class: "small quiet" }, noise.u_says),
      ),
    ),
  );
}

/** @param {string} name @param {string} value @param {string} more */
function fact(name, value, more) {
  return el(
    "div",
    {},
    el("dt", {}, name),
    el("dd", {}, value, el("small", {}, more)),
  );
}

/** @param {{ number: string, prior: number, needed_shift_sigma: number }[]} numbers */
function restsOn(numbers) {
  if (!numbers.length) {
    return el(
      "p",
      { class: "small quiet" },
      "It rests on the readings alone: no stated number would explain the same by being off.",
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
          `${r.number.replaceAll("_", " ")}, stated to ${text(r.prior, 2)}: if it were off by ${
            text(Math.abs(r.needed_shift_sigma), 2)
          } standard uncertainties it would explain the same.`,
        )
      ),
    ),
  );
}

/** @param {PageDocument} whole */
function notes(whole) {
  if (!whole.data.notes.length) return null;
  return el("ul", { class: "plain small quiet" }, whole.data.notes.map((n) => el("li", {}, n)));
}
