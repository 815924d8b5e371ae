/**
 * 7. What could be missing: a card for each candidate, with its switch and its tell-tale picture.
 *
 * The picture lays what the effect adds (its signature) over the residual that it has to explain,
 * along the column in which the signature shows most.
 */

/** @import { Candidate, Column, Model, Parameter } from "../types.d.ts" */
import { bar, bodyOf, el, fill, svg } from "../lib/dom.js";
import { onTheme, saveDrawing, theme, thin } from "../lib/figure.js";
import { markSwitches, switchOf } from "./bar.js";
import { canSwitch, isOn, ROUGH } from "../lib/models.js";
import { nameOf } from "../lib/names.js";
import { fixed, plain, probability } from "../lib/numbers.js";
import { columnOf, documentShown, modelOf, modelShown, on, size, state } from "../lib/store.js";

const FIRST_CARDS = 6;
const POINTS = 260;
// Rows that are looked at for the column along which a signature shows.
const SAMPLE = 1500;
let all = false;
/** @type {Map<string, { node: HTMLElement, of: Model | undefined }>} by candidate */
let cards = new Map();

export function setUpCandidates() {
  on(["document", "unit"], drawAnew);
  on(["models", "model"], follow);
  onTheme(() => state.document && drawAnew());
}

function drawAnew() {
  cards = new Map();
  draw();
}

function draw() {
  const whole = documentShown();
  const place = bodyOf("missing");
  if (!whole.candidates.length) {
    const agrees = ["complete", "rig"].includes(whole.answer?.verdict.kind);
    return fill(
      place,
      el(
        "p",
        { class: "quiet" },
        whole.reasons.candidates ??
          `None of the known effects is visible in these readings. ${
            agrees
              ? "The model of the case agrees with them within their noise."
              : "The model of the case does not agree with them within their noise either."
          }`,
      ),
    );
  }
  const folded = all
    ? whole.candidates
    : whole.candidates.filter((c, k) =>
      k < FIRST_CARDS || c.in_answer || c.is_rival || c.perhaps !== null || isOn(c.effect)
    );
  const rest = whole.candidates.length - folded.length;
  fill(
    place,
    el(
      "p",
      { class: "quiet" },
      "A switch adds the effect to the model and refits it; the curves, the residual and the error ladder follow. Dots: the residual of the drive as stated. Lines: the change that the effect makes, with the numbers of the drive refitted; dashed where the torque falls.",
    ),
    el("div", { class: "cards" }, folded.map(cardOf)),
    rest > 0 &&
      el(
        "p",
        {},
        el(
          "button",
          { type: "button", class: "no-print", onclick: () => unfold(folded.length) },
          `${rest} less likely candidate${rest === 1 ? "" : "s"}`,
        ),
      ),
    notFitted(),
  );
}

/** All cards, the focus on the first that was hidden. @param {number} before cards that were there */
function unfold(before) {
  all = true;
  draw();
  const next = bodyOf("missing").querySelectorAll(".candidate")[before]?.querySelector("button");
  next?.focus({ preventScroll: true });
}

/** Whether the answer names it. @param {Candidate} c */
function named(c) {
  return documentShown().answer?.verdict.effects.includes(c.effect) ?? false;
}

/** A card that has to come in sight, or what a card says of another model; else switches and frames. */
function follow() {
  const place = bodyOf("missing");
  const { candidates } = documentShown();
  const there = (/** @type {Candidate} */ c) => cards.get(c.effect)?.node.isConnected;
  if (candidates.some((c) => isOn(c.effect) && !there(c))) draw();
  else for (const c of candidates) if (there(c)) cardOf(c);
  for (const { node } of cards.values()) {
    node.classList.toggle("on", isOn(node.dataset.card ?? ""));
  }
  markSwitches(place);
}

/** The model whose numbers a card shows: the model shown where it has the effect, else the effect alone. @param {Candidate} c */
function modelBehind(c) {
  return modelShown().effects.includes(c.effect) ? modelShown() : modelOf(c.key);
}

/** The card of a candidate: the element stays, what it says follows its model. @param {Candidate} c */
function cardOf(c) {
  const of = modelBehind(c);
  const drawn = cards.get(c.effect);
  if (drawn && drawn.of === of) return drawn.node;
  const node = drawn?.node ??
    el("article", { class: "card candidate", "aria-label": c.label, "data-card": c.effect });
  fill(node, card(c));
  node.classList.toggle("on", isOn(c.effect));
  cards.set(c.effect, { node, of });
  return node;
}

/** What stands on a card. @param {Candidate} c */
function card(c) {
  const m = modelBehind(c), alone = modelOf(c.key);
  return [
    el(
      "div",
      { class: "row between" },
      canSwitch(c.effect) ? switchOf(c.effect) : el("b", {}, c.effect.replaceAll("_", " ")),
      named(c)
        ? el("span", { class: "tag answer" }, "in the answer")
        : c.is_rival
        ? el("span", { class: "tag rival" }, "rival")
        : c.perhaps !== null
        ? el("span", { class: "tag rival" }, `perhaps, ${probability(c.perhaps)}`)
        : el("span", { class: "tag" }, c.class),
    ),
    el("h3", {}, c.label),
    c.probability === null || c.moved
      ? el(
        "p",
        { class: "small quiet" },
        "A stated number of the drive: the answer lets it move within its stated uncertainty.",
        !c.moved && " Here its value is free.",
      )
      : el(
        "div",
        { class: "chance" },
        el("span", { class: "quiet" }, "probability that only this effect is missing"),
        el("div", { class: "bar" }, bar(c.probability)),
        el("b", {}, probability(c.probability)),
      ),
    c.moved && el(
      "p",
      { class: "small" },
      "off by ",
      el("b", {}, c.moved.replace("-", "−")),
    ),
    m && m !== alone && el("p", { class: "small quiet" }, `in the model shown: ${m.label}`),
    m && parameters(m, c.effect),
    c.tell_tale && el("p", { class: "tell" }, `Typical sign: ${c.tell_tale}`),
    alone?.signature_arcsec && picture(c, alone.signature_arcsec),
    el(
      "p",
      { class: "small quiet tiny" },
      [
        m?.held_out_rmse_arcsec && `held out ${size(m.held_out_rmse_arcsec)} ${state.unit}`,
        c.surviving_fraction !== null &&
        `${
          (100 * c.surviving_fraction).toFixed(0)
        } % of its signature remains when the numbers of the drive are refitted`,
        c.rival &&
        `most similar: ${c.rival.replaceAll("_", " ")} (correlation ${
          fixed(c.rival_correlation, 2)
        })`,
      ].filter(Boolean).join(" · "),
    ),
  ];
}

/**
 * Numbers with their uncertainty, as the answer words them; of one effect where it is given.
 * @param {Model} m @param {string} [effect]
 */
export function parameters(m, effect) {
  const own = m.parameters.filter((p) => !effect || p.effect === effect);
  if (!own.length) return null;
  return el(
    "ul",
    { class: "plain small" },
    !m.converged && el("li", {}, el("b", { class: "rough" }, ROUGH)),
    own.map((p) =>
      el(
        "li",
        {},
        nameOf(p.name),
        " ",
        el("b", {}, sizeOf(p)),
        p.at_bound && " (at the limit of its range)",
        m.converged && p.u === null && p.why_no_u && ` (no uncertainty: ${p.why_no_u})`,
      )
    ),
  );
}

/** The value in the words of the answer. @param {Parameter} p */
function sizeOf(p) {
  return p.value_text.replaceAll("+-", "±").replace(/^-/, "−");
}

/** The column along which the signature varies most, by the spread of its means. @param {Column} signature */
function along(signature) {
  const whole = documentShown();
  let best = { key: "torque_Nm", share: 0, by: false };
  for (const column of whole.columns) {
    if (column.key === "measured_arcsec" || column.key === "branch" || column.key === "run") {
      continue;
    }
    const values = /** @type {(number | null)[]} */ (columnOf(column.key));
    if (typeof values[0] !== "number") continue;
    // Half a point in favour of the torque, which everyone reads first.
    const share = explained(signature, values) + (column.key === "torque_Nm" ? 0.1 : 0);
    if (share > best.share) best = { key: column.key, share, by: false };
  }
  return best.key;
}

/** Share of a signature's variance between stretches of a column and ways of the torque. @param {Column} y @param {Column} x */
function explained(y, x) {
  const { branch } = documentShown().readings;
  const step = Math.ceil(y.length / SAMPLE);
  const known = y.map((_, i) => i).filter((i) => i % step === 0 && y[i] !== null && x[i] !== null);
  if (!known.length) return 0;
  const xs = known.map((i) => Number(x[i]));
  const low = Math.min(...xs), span = Math.max(...xs) - low || 1;
  /** @type {Map<string, [number, number]>} */
  const cells = new Map();
  let total = 0;
  for (const i of known) total += Number(y[i]) / known.length;
  let variance = 0;
  known.forEach((i, k) => {
    const cell = `${Math.min(9, Math.floor((10 * (xs[k] - low)) / span))} ${branch[i]}`;
    const [sum, n] = cells.get(cell) ?? [0, 0];
    cells.set(cell, [sum + Number(y[i]), n + 1]);
    variance += (Number(y[i]) - total) ** 2;
  });
  let between = 0;
  for (const [sum, n] of cells.values()) between += n * (sum / n - total) ** 2;
  return variance > 0 ? between / variance : 0;
}

/** Dots of the residual, the signature over them: filled where the torque rises, open where it falls. @param {Candidate} c @param {Column} signature */
function picture(c, signature) {
  const whole = documentShown();
  const r = whole.readings;
  const t = theme();
  const key = along(signature);
  const values = /** @type {(number | null)[]} */ (columnOf(key));
  const residual = whole.models[0].residual_arcsec;
  const known = r.row.map((_, i) => i).filter((i) =>
    residual[i] !== null && signature[i] !== null && values[i] !== null
  );
  if (!known.length) return null;
  const dots = thin(known, values, residual, POINTS);
  const [w, h, left, bottom] = [300, 118, 30, 20];
  const ends = (/** @type {number[]} */ v) => [Math.min(...v), Math.max(...v)];
  const [x0, x1] = ends(known.map((i) => Number(values[i])));
  const [y0, y1] = ends(dots.flatMap((i) => [Number(residual[i]), Number(signature[i])]));
  const px = (/** @type {number} */ v) => left + 4 + ((w - left - 8) * (v - x0)) / (x1 - x0 || 1);
  const py = (/** @type {number} */ v) => 4 + (h - bottom - 8) * (1 - (v - y0) / (y1 - y0 || 1));
  const place = (/** @type {number} */ i, /** @type {Column} */ y) =>
    `M${px(Number(values[i])).toFixed(1)} ${py(Number(y[i])).toFixed(1)}h0`;
  const drawing = svg(
    "svg",
    {
      viewBox: `0 0 ${w} ${h}`,
      width: "100%",
      role: "img",
      "aria-label": `Signature of ${c.label} over the residual, along ${nameOf(key)}`,
      "font-family": "system-ui, sans-serif",
    },
    svg("line", {
      x1: left,
      x2: w,
      y1: py(Math.min(Math.max(0, y0), y1)),
      y2: py(Math.min(Math.max(0, y0), y1)),
      stroke: t.line,
    }),
    svg("path", {
      d: dots.map((i) => place(i, residual)).join(""),
      stroke: t.quiet,
      "stroke-width": 3,
      "stroke-linecap": "round",
      opacity: 0.5,
    }),
    ["up", "none", "down"].map((branch) =>
      svg("path", {
        d: means(dots, values, signature, branch, px, py, x0, x1),
        fill: "none",
        stroke: branch === "down" ? t.warn : t.accent,
        "stroke-width": 2,
        "stroke-linejoin": "round",
        "stroke-dasharray": branch === "down" ? "5 2.5" : null,
      })
    ),
    svg("text", { x: 0, y: 11, "font-size": 9.5, fill: t.quiet }, size(y1)),
    svg("text", { x: 0, y: h - bottom - 2, "font-size": 9.5, fill: t.quiet }, size(y0)),
    svg("text", { x: left + 4, y: h - 6, "font-size": 9.5, fill: t.quiet }, plain(x0, 3)),
    svg("text", {
      x: w / 2 + left / 2,
      y: h - 6,
      "font-size": 9.5,
      fill: t.quiet,
      "text-anchor": "middle",
    }, `${nameOf(key)}; residual, ${state.unit}`),
    svg(
      "text",
      { x: w - 2, y: h - 6, "font-size": 9.5, fill: t.quiet, "text-anchor": "end" },
      plain(x1, 3),
    ),
  );
  return el(
    "div",
    { class: "plot" },
    drawing,
    el(
      "button",
      {
        type: "button",
        class: "text small no-print",
        onclick: () => saveDrawing(drawing, `signature_${c.effect}`),
      },
      "SVG",
      el("span", { class: "visually-hidden" }, ` of the signature of ${c.label}`),
    ),
  );
}

/**
 * A line through the means of the signature, of one way of the torque.
 * @param {number[]} rows @param {Column} x @param {Column} y @param {string} branch
 * @param {(v: number) => number} px @param {(v: number) => number} py @param {number} x0 @param {number} x1
 */
function means(rows, x, y, branch, px, py, x0, x1) {
  const way = documentShown().readings.branch;
  /** @type {Map<number, [number, number, number]>} */
  const cells = new Map();
  for (const i of rows) {
    if (way[i] !== branch) continue;
    const cell = Math.round((40 * (Number(x[i]) - x0)) / (x1 - x0 || 1));
    const [sx, sy, n] = cells.get(cell) ?? [0, 0, 0];
    cells.set(cell, [sx + Number(x[i]), sy + Number(y[i]), n + 1]);
  }
  return [...cells].sort((a, b) => a[0] - b[0])
    .map(([, [sx, sy, n]], k) =>
      `${k ? "L" : "M"}${px(sx / n).toFixed(1)} ${py(sy / n).toFixed(1)}`
    ).join("");
}

/** Effects of the library that these readings cannot show. */
function notFitted() {
  const absent = documentShown().library.filter((e) => e.why_not);
  if (!absent.length) return null;
  return el(
    "details",
    {},
    el("summary", {}, `${absent.length} effects that these readings cannot show`),
    el("ul", { class: "plain small" }, absent.map((e) => el("li", {}, `${e.label}: ${e.why_not}`))),
  );
}
