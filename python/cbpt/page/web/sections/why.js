/** 5. Why this and not that: the combinations that the readings leave, and each rival of the answer. */

/** @import { Combination, PageDocument, Rival } from "../types.d.ts" */
import { bodyOf, el, fill, showSection, svg, table } from "../lib/dom.js";
import { inPrint, nameOf } from "../lib/names.js";
import { probability, text } from "../lib/numbers.js";
import { documentShown, modelOf, on, size, state } from "../lib/store.js";

export function setUpWhy() {
  on(["document", "unit"], draw);
}

function draw() {
  const whole = documentShown();
  const parts = [combinations(whole), against(whole)].filter(Boolean);
  showSection("why", parts.length > 0);
  fill(bodyOf("why"), el("div", { class: "grid" }, parts));
}

/** The sets of effects that the readings leave, each with its own errors. @param {PageDocument} whole */
function combinations(whole) {
  const list = whole.combinations;
  if (list.length < 2) return null;
  const row = (/** @type {Combination} */ c) => [
    [
      c.label,
      el(
        "div",
        { class: "small quiet" },
        (c.key === null ? null : modelOf(c.key))?.parameters.map((p) =>
          `${nameOf(p.name)} ${inPrint(p.value_text)}`
        ).join(", "),
      ),
    ],
    probability(c.probability),
    size(c.rmse_arcsec),
    size(c.held_out_arcsec),
  ];
  const drawn = table(
    "Combinations of effects that the readings leave",
    [
      "effects, and nothing else",
      { text: "probability", number: true },
      { text: `error, ${state.unit}`, number: true },
      { text: "held out", number: true },
    ],
    list.map(row),
  );
  return el(
    "div",
    { class: "card", id: "combinations" },
    el("h3", {}, "Combinations that the readings leave"),
    drawn,
  );
}

/** The answer against each rival: in words, and where the readings speak for which. @param {PageDocument} whole */
function against(whole) {
  if (!whole.why.length) return null;
  return el(
    "div",
    { class: "card" },
    el("h3", {}, `Why ${whole.combinations[0]?.label ?? "this"}, and not another`),
    el(
      "p",
      { class: "small quiet" },
      "Bars: by how much χ² of the rival is larger in these readings. To the right they speak for the answer, to the left for the rival.",
    ),
    el(
      "div",
      { class: "rivals" },
      whole.why.map((rival) =>
        el(
          "div",
          { class: "rival" },
          el("p", { class: "small" }, inPrint(rival.sentence[state.unit])),
          speaking(rival),
        )
      ),
    ),
  );
}

const MOST_BARS = 8;

/** Bars of the column that decides, else of the first. @param {Rival} rival */
function speaking(rival) {
  const column = rival.by.find((c) => c.decides) ?? rival.by[0];
  if (!column) return null;
  const most = Math.max(...column.groups.map((g) => Math.abs(g.delta_chi2)), 1e-9);
  const shown = [...column.groups].sort((a, b) => Math.abs(b.delta_chi2) - Math.abs(a.delta_chi2))
    .slice(0, MOST_BARS);
  return el(
    "figure",
    { class: "speaking" },
    el("figcaption", { class: "small quiet" }, `Δχ² by ${column.label}`),
    column.groups.filter((g) => shown.includes(g)).map((g) =>
      el(
        "div",
        { class: "speaks" },
        el("span", { class: "small" }, g.label),
        svg(
          "svg",
          { width: 120, height: 10, viewBox: "-60 0 120 10", "aria-hidden": "true" },
          svg("line", { class: "zero", x1: 0, x2: 0, y1: 0, y2: 10 }),
          svg("rect", {
            class: g.delta_chi2 < 0 ? "against" : "for",
            x: (Math.min(g.delta_chi2, 0) / most) * 58,
            width: (Math.abs(g.delta_chi2) / most) * 58,
            y: 1,
            height: 8,
          }),
        ),
        el(
          "span",
          { class: "small number" },
          `${g.delta_chi2 > 0 ? "+" : ""}${text(g.delta_chi2)}`,
        ),
      )
    ),
  );
}
