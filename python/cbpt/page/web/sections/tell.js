/** 12. What the campaign can detect and tell apart. */

/** @import { Theme } from "../lib/figure.js" */
import { get, isLive } from "../lib/api.js";
import { bodyOf, el, fill, table } from "../lib/dom.js";
import { Figure, safe } from "../lib/figure.js";
import { asSentence, nameOf } from "../lib/names.js";
import { fixed, text } from "../lib/numbers.js";
import { documentShown, hasBalls, on, state } from "../lib/store.js";

const SIGNS =
  /** @type {Record<string, string>} */ ({ apart: "", above: "+", not_here: "×", twins: "=" });
const MEANS = /** @type {Record<string, string>} */ ({
  apart: "these runs separate them at the smallest detectable size",
  above: "these runs separate them only above the smallest detectable size",
  not_here: "these runs do not separate them",
  twins: "no reading of this rig separates them",
});

// As long without a switch is taken for a pause.
const IDLE_MS = 2500;

/** @type {Figure} */
let figure;
/** @type {HTMLElement} */
let matrix;
/** @type {HTMLElement} */
let sizes;

export function setUpTell() {
  const plot = el("div", { id: "matrix" });
  matrix = el(
    "div",
    { class: "card" },
    el("h3", {}, "Which effects these runs can separate"),
    plot,
  );
  sizes = el("div", { class: "card", id: "sizes" });
  fill(
    bodyOf("tell"),
    el("div", { class: "grid halves" }, sizes, matrix),
  );
  figure = new Figure(
    plot,
    "isolability",
    "Correlation of the effects in this campaign",
    build,
    { height: 520, paper: 430 },
  );
  figure.under(
    el(
      "span",
      { class: "small quiet" },
      "Correlation of the signatures after the refit, at the smallest detectable size. Blank: these runs separate the pair. +: only if the effects are larger. ×: these runs do not separate it. =: no reading of this rig separates it.",
    ),
  );
  on(["document"], () => {
    drawMatrix();
    later();
  });
  on(["model"], later);
  // Or as soon as somebody looks at where it will stand.
  new IntersectionObserver((seen) => seen.some((e) => e.isIntersecting) && ask()).observe(sizes);
}

/** @type {number | undefined} */
let waiting;

/** Ask once nobody has asked for a model for a while. */
function later() {
  clearTimeout(waiting);
  waiting = setTimeout(ask, IDLE_MS);
}

function drawMatrix() {
  // Of a torsion spring nothing is plausible before there are readings, so no plan is judged.
  sizes.hidden = !hasBalls();
  drawSizes();
  const there = names().length > 1;
  matrix.hidden = !there;
  if (there) figure.draw();
}

let asking = false;

/** What the campaign can tell takes some seconds more than the answer, so it is asked for apart. */
async function ask() {
  const whole = state.document;
  if (!isLive() || asking || !whole?.answer || whole.isolability) return;
  asking = true;
  try {
    const found = await get("isolability");
    if (state.document !== whole) return later();
    whole.isolability = found.isolability;
    if (found.why) whole.reasons.isolability = found.why;
    drawMatrix();
  } catch {
    // Other files have been opened meanwhile, or the server has ended, which others tell.
  } finally {
    asking = false;
  }
}

/** Effects that the campaign shows. @returns {string[]} */
function names() {
  /** @type {{ effects: string[] }[]} */
  const pairs = documentShown().isolability?.pairs ?? [];
  return [...new Set(pairs.flatMap((p) => p.effects))];
}

/** @param {Theme} t */
function build(t) {
  const pairs = documentShown().isolability?.pairs ?? [];
  const list = names();
  const place = new Map(list.map((n, k) => [n, k]));
  /** @type {(number | null)[][]} */
  const z = list.map(() => list.map(() => null));
  const hover = list.map(() => list.map(() => ""));
  /** @type {any[]} */
  const annotations = [];
  for (const p of pairs) {
    const [one, other] = p.effects.map((/** @type {string} */ e) => place.get(e)).sort((
      /** @type {number} */ a,
      /** @type {number} */ b,
    ) => a - b);
    z[other][one] = p.correlation;
    hover[other][one] = `${safe(p.effects.join(" and ").replaceAll("_", " "))}: ${
      MEANS[p.verdict] ?? p.verdict
    }`;
    if (SIGNS[p.verdict]) {
      annotations.push({
        x: one,
        y: other,
        text: SIGNS[p.verdict],
        showarrow: false,
        font: { size: 12, color: (p.correlation > 0.55) !== t.dark ? "#ffffff" : "#10161c" },
      });
    }
  }
  const texts = list.map((n) => safe(n.replaceAll("_", " ")));
  // Names stand upright where there is little room between them.
  const narrow = figure.area.clientWidth < 420;
  const axis = {
    tickvals: list.map((_, k) => k),
    ticktext: texts,
    showgrid: false,
    zeroline: false,
    ticks: "",
    automargin: true,
    tickfont: { size: narrow ? 9 : 10.5 },
  };
  // Nothing stands above the diagonal: the key has its place there.
  const key = { x: 0.97, xanchor: "right", y: 0.98, yanchor: "top", len: 0.42 };
  return {
    data: [{
      type: "heatmap",
      z,
      x: list.map((_, k) => k),
      y: list.map((_, k) => k),
      zmin: 0,
      zmax: 1,
      xgap: 1.5,
      ygap: 1.5,
      colorscale: t.single,
      text: hover,
      hoverongaps: false,
      hovertemplate: "%{text}<br>correlation %{z:.3f}<extra></extra>",
      colorbar: {
        ...key,
        thickness: 11,
        outlinewidth: 0,
        title: { text: "correlation", font: { size: 11, color: t.quiet } },
        tickfont: { color: t.quiet },
      },
    }],
    layout: {
      margin: { l: 20, r: 6, t: 8, b: 20 },
      annotations,
      xaxis: { ...axis, tickangle: narrow ? -90 : -60 },
      yaxis: { ...axis, autorange: "reversed" },
    },
  };
}

function drawSizes() {
  const whole = documentShown();
  const found = whole.isolability;
  if (!found) {
    return fill(
      sizes,
      el("h3", {}, "What these runs can detect"),
      el("p", { class: "quiet" }, asSentence(whole.reasons.isolability ?? "Not computed.")),
    );
  }
  const size = (/** @type {Record<string, number> | null | undefined} */ values) =>
    values ? Object.values(values).map((v) => text(v, 3)).join(", ") : "never";
  fill(
    sizes,
    el("h3", {}, "Smallest size that these runs detect"),
    table(
      "Smallest size of each effect that this campaign detects",
      ["effect", { text: "in 50 % of cases", number: true }, { text: "in 95 %", number: true }],
      found.effects.map((/** @type {any} */ e) => [
        [
          e.form.replaceAll("_", " ").replace(":", ": "),
          el(
            "div",
            { class: "small quiet" },
            e.shown
              ? nameOf(e.shown.number)
              : Object.keys(e.smallest.even ?? e.smallest.sure ?? {}).map(nameOf).join(", "),
          ),
        ],
        e.shown?.even ?? size(e.smallest.even),
        e.shown?.sure ?? size(e.smallest.sure),
      ]),
    ),
    found.unseen?.length > 0 &&
      el(
        "p",
        { class: "small quiet" },
        "Not detectable: ",
        found.unseen.map((/** @type {any} */ u) => `${u.effect.replaceAll("_", " ")} (${u.why})`)
          .join("; "),
        ".",
      ),
    twins(found),
  );
}

/** @param {any} found */
function twins(found) {
  const list = found.pairs.filter((/** @type {any} */ p) =>
    p.verdict === "twins" || p.verdict === "not_here"
  );
  if (!list.length) return null;
  return el(
    "details",
    {},
    el("summary", {}, `${list.length} pairs that these runs do not separate`),
    el(
      "ul",
      { class: "plain small" },
      list.map((/** @type {any} */ p) =>
        el(
          "li",
          {},
          `${p.effects.join(" and ").replaceAll("_", " ")} (correlation ${
            fixed(p.correlation, 3)
          })`,
        )
      ),
    ),
  );
}
