/**
 * 2. Readings against model: elastic angle over torque, the residual below on the same axis.
 *
 * Preload levels have colours, the way of the torque has its marker: a filled triangle up, an open
 * one down. A box drawn in any plot selects readings in all of them.
 */

/** @import { Theme } from "../lib/figure.js" */
/** @import { Points, Sign } from "../lib/points.js" */
/** @import { Branch, Model } from "../types.d.ts" */
import { bodyOf, byId, el, fill, svg } from "../lib/dom.js";
import { Figure, MOST_POINTS, onTheme, safe, theme, thin } from "../lib/figure.js";
import { reach, room, within } from "../lib/limits.js";
import {
  documentShown,
  inUnit,
  modelOf,
  modelShown,
  on,
  scale,
  select,
  size,
  state,
  tell,
  visible,
} from "../lib/store.js";

/** @type {Record<Branch, { sign: Sign, dash: string, name: string }>} */
export const BRANCHES = {
  up: { sign: "up", dash: "solid", name: "torque rising" },
  down: { sign: "down", dash: "5px,3px", name: "torque falling" },
  none: { sign: "dot", dash: "solid", name: "torque held" },
};
// More settings than this share colours of a ramp without keys of their own.
const MOST_KEYS = 12;
// Readings drawn, each in both plots, but for a few of each group at least; a browser takes as long
// for the marks as for all else.
const MOST_MARKED = 1200;

/** @type {Figure} */
let figure;

export function setUpReadings() {
  const whole = bodyOf("readings");
  const legend = el("div", { class: "legend", id: "legend" });
  const plot = el("div", { id: "readings-plot" });
  const rows = el("div", { class: "stack", id: "rows" });
  fill(whole, el("div", { class: "card stack" }, legend, plot, rows));
  figure = new Figure(
    plot,
    "readings",
    "Elastic angle over torque, measured and model, with the residual below",
    build,
    {
      height: innerWidth < 720 ? 520 : 620,
      paper: 240,
      bar: true,
      first: true,
    },
  );
  on(["document", "filter", "model"], drawLegend);
  onTheme(() => state.document && drawLegend());
  on(["document", "filter", "model", "unit", "selection"], () => figure.drawNow());
  figure.onFirst = () => {
    performance.mark("cbpt-plot-alive");
    document.documentElement.dataset.ready = "true";
    // A sketch knows nothing of boxes; the place is kept, so that nothing moves.
    byId("box-hint").style.visibility = "";
    listenToBoxes();
  };
  rows.before(
    el(
      "div",
      { class: "under" },
      el(
        "span",
        { class: "small quiet" },
        el("span", { id: "thinned" }),
        el(
          "span",
          { class: "no-print", id: "box-hint", style: "visibility: hidden" },
          " Drag a box to select readings; double-click to clear the selection. Choose a run to see the model reading by reading. ",
        ),
        el("span", { id: "mean-over" }),
        el("span", { id: "beyond" }),
      ),
      figure.save,
    ),
  );
}

function listenToBoxes() {
  const area = /** @type {any} */ (figure.area);
  area.on("plotly_selected", (/** @type {any} */ event) => {
    if (!event?.range) return;
    const x = event.range.x ?? event.range.x2;
    const y = event.range.y, y2 = event.range.y2;
    const { readings } = documentShown();
    const residual = modelShown().residual_arcsec;
    const s = scale();
    const inside = (/** @type {number | null} */ v, /** @type {number[]} */ ends) =>
      v !== null && v >= Math.min(...ends) && v <= Math.max(...ends);
    select(
      readings.row.map((_, i) => i).filter((i) =>
        visible(i) && inside(readings.torque_Nm[i], x) &&
        (y ? inside(readings.measured_arcsec[i] * s, y) : inside((residual[i] ?? NaN) * s, y2))
      ),
    );
  });
  area.on("plotly_deselect", () => select([]));
}

/** A colour for each setting (preload level). @param {Theme} t @returns {string[]} */
export function levelColours(t) {
  return t.levels(documentShown().data.settings.length);
}

function drawLegend() {
  const whole = documentShown();
  byId("mean-over").textContent = !inOrder() && whole.curves_mean_over.length
    ? "Lines show means; the residual stands at each reading."
    : "";
  const colours = levelColours(theme());
  const names = whole.data.settings;
  const runs = [...new Set(whole.readings.run_index)];
  const first = (/** @type {number} */ run) =>
    whole.readings.run[whole.readings.run_index.indexOf(run)];
  fill(
    byId("legend"),
    names.length > MOST_KEYS ? rampKey(names, colours) : names.map((name, level) =>
      el(
        "button",
        {
          type: "button",
          class: "chip",
          "aria-pressed": String(!state.hidden.has(level)),
          title: "Show or hide",
          onclick: () => {
            if (!state.hidden.delete(level)) state.hidden.add(level);
            tell("filter");
          },
        },
        svg(
          "svg",
          { width: 11, height: 11, "aria-hidden": "true" },
          svg("circle", { cx: 5.5, cy: 5.5, r: 5, fill: colours[level] }),
        ),
        name,
      )
    ),
    [...new Set(whole.readings.branch)].map((branch) =>
      el("span", { class: "key" }, sign(branch), BRANCHES[branch].name)
    ),
    lineKeys(),
    runs.length > 1 && el(
      "label",
      { class: "inline no-print" },
      "Run",
      el(
        "select",
        {
          id: "run",
          onchange: (e) => {
            state.run = e.target.value === "" ? null : Number(e.target.value);
            tell("filter");
          },
        },
        el("option", { value: "" }, `all ${runs.length}`),
        runs.slice(0, 500).map((run) =>
          el("option", { value: run, selected: run === state.run }, String(first(run)))
        ),
      ),
    ),
  );
}

/** Many settings: the colours of the first and the last, and those between. @param {string[]} names @param {string[]} colours */
function rampKey(names, colours) {
  const ramp = `linear-gradient(90deg, ${
    [0, 0.25, 0.5, 0.75, 1].map((share) => colours[Math.round(share * (colours.length - 1))]).join(
      ", ",
    )
  })`;
  return el(
    "span",
    { class: "key", id: "ramp" },
    names[0],
    el("span", { class: "ramp", style: `background: ${ramp}` }),
    `${names[names.length - 1]} (${names.length} settings)`,
  );
}

/** Whether the model is drawn as it went, reading by reading: of one run, where means would be blunt. */
function inOrder() {
  const { readings, data } = documentShown();
  return state.run !== null ||
    (data.settings.length === 1 && readings.run_index.every((run) => run === 0) &&
      readings.row.length <= MOST_POINTS);
}

/** What the lines are: the model shown, on the way back dashed; and the band of the noise. */
function lineKeys() {
  const whole = documentShown();
  const ways = new Set(whole.curves.map((line) => BRANCHES[line.branch].dash));
  const over = whole.curves_mean_over;
  const mean = inOrder()
    ? ", reading by reading"
    : over.length
    ? `, mean over ${over.map((o) => `${o}s`).join(" and ")}`
    : "";
  const line = (/** @type {string} */ dash) =>
    svg(
      "svg",
      { width: 24, height: 10, "aria-hidden": "true" },
      svg("line", {
        x1: 1,
        x2: 23,
        y1: 5,
        y2: 5,
        stroke: theme().ink,
        "stroke-width": 2,
        "stroke-dasharray": dash === "solid" ? null : dash.replaceAll("px", ""),
      }),
    );
  return [
    el(
      "span",
      { class: "key", id: "model-key" },
      line("solid"),
      `model: ${modelShown().label}${mean}`,
    ),
    !inOrder() && ways.has(BRANCHES.down.dash) && ways.size > 1 &&
    el("span", { class: "key" }, line(BRANCHES.down.dash), "model, torque falling"),
    whole.readings.u_arcsec && el(
      "span",
      { class: "key" },
      svg(
        "svg",
        { width: 8, height: 14, "aria-hidden": "true" },
        svg("line", { x1: 4, x2: 4, y1: 1, y2: 13, stroke: theme().ink, opacity: 0.45 }),
      ),
      "± stated uncertainty (k = 1)",
    ),
    modelShown().key !== "stated" && el(
      "span",
      { class: "key" },
      svg(
        "svg",
        { width: 8, height: 8, "aria-hidden": "true" },
        svg("circle", { cx: 4, cy: 4, r: 2, fill: theme().quiet, opacity: 0.5 }),
      ),
      "residual of the drive as stated",
    ),
    noiseOf() !== null && el(
      "span",
      { class: "key" },
      svg(
        "svg",
        { width: 24, height: 10, "aria-hidden": "true" },
        svg("rect", { width: 24, height: 10, fill: theme().quiet, opacity: 0.25 }),
      ),
      `± 2 × noise (${whole.noise?.noise_floor_of ?? "stated uncertainty"})`,
    ),
  ];
}

/** @param {Branch} branch */
function sign(branch) {
  const ink = theme().ink;
  const d = branch === "up"
    ? "M6 1 11 10 1 10Z"
    : branch === "down"
    ? "M6 10 11 1 1 1Z"
    : "M6 1a5 5 0 1 0 .01 0Z";
  return svg(
    "svg",
    { width: 12, height: 12, "aria-hidden": "true" },
    svg("path", { d, fill: branch === "down" ? "none" : ink, stroke: ink, "stroke-width": 1.3 }),
  );
}

/** @param {Theme} t */
function build(t) {
  const whole = documentShown();
  const r = whole.readings;
  const m = modelShown();
  const colours = levelColours(t);
  const s = scale();
  const groups = grouped();
  const all = groups.reduce((sum, g) => sum + g.rows.length, 0);
  const share = Math.min(1, MOST_MARKED / Math.max(all, 1));
  /** @type {Points[]} */
  const points = [];
  const before = modelOf("stated");
  if (before && m.key !== "stated") {
    const rows = thin(groups.flatMap((g) => g.rows), r.torque_Nm, before.residual_arcsec, 600);
    points.push({
      axis: "y2",
      x: rows.map((i) => r.torque_Nm[i]),
      y: inUnit(rows.map((i) => before.residual_arcsec[i])),
      sign: "small",
      colour: t.quiet,
      opacity: 0.35,
    });
  }
  /** @type {number[]} */
  const drawn = [];
  for (const { level, branch, rows: every } of groups) {
    const most = Math.max(8, Math.ceil(share * every.length));
    const rows = thin(every, r.torque_Nm, m.residual_arcsec, most);
    drawn.push(...rows);
    for (const part of parted(rows)) {
      const common = {
        x: part.rows.map((i) => r.torque_Nm[i]),
        u: part.bars && r.u_arcsec ? inUnit(part.rows.map((i) => r.u_arcsec?.[i] ?? null)) : null,
        sign: BRANCHES[branch].sign,
        colour: colours[level],
        opacity: part.opacity,
      };
      points.push({ ...common, axis: "y", y: inUnit(part.rows.map((i) => r.measured_arcsec[i])) });
      points.push({ ...common, axis: "y2", y: inUnit(part.rows.map((i) => m.residual_arcsec[i])) });
    }
  }
  const data = [...hovered(drawn)];
  for (const line of inOrder() ? [] : whole.curves) {
    const y = line.angle_arcsec[m.key];
    if (!y || state.hidden.has(line.level)) continue;
    data.push({
      type: "scatter",
      mode: "lines",
      x: line.torque_Nm,
      y: inUnit(y),
      hoverinfo: "skip",
      line: { color: colours[line.level], width: 1.8, dash: BRANCHES[line.branch].dash },
    });
  }
  if (inOrder()) data.push(lineOfRun(t, s));
  byId("thinned").textContent = drawn.length < all
    ? `${drawn.length} of ${all} readings are drawn, the extremes among them. `
    : "";
  const measured = withBars(drawn.map((i) => r.measured_arcsec[i]), drawn);
  // A model near its holding limit goes as far beyond the readings as they are wide, no farther.
  const [low, high] = room(measured) ?? [0, 0];
  const model = drawn.map((i) => m.model_arcsec[i]);
  const ends = [2 * low - high, 2 * high - low];
  const residual = reachOf(before, m);
  byId("beyond").textContent = beyondAxes(model, ends, m, residual);
  const angles = inUnit([...measured, ...within(model, ends)]);
  const ranges = { x: room(drawn.map((i) => r.torque_Nm[i])), y: room(angles) };
  const layout = layoutOf(t, ranges, residual);
  return { data, layout, points };
}

/**
 * How far the axis of residuals goes: over all of the model shown but what is far from all others.
 * @param {Model | undefined} before @param {Model} m
 */
function reachOf(before, m) {
  const every = documentShown().readings.row.map((_, i) => i);
  return Math.max(
    before ? reach(withBars(before.residual_arcsec, every), 0.9, 6) : 0,
    reach(withBars(m.residual_arcsec, every), 0.9, 20),
  );
}

/**
 * What the axes do not show of the model, in words.
 * @param {(number | null)[]} model @param {number[]} ends @param {Model} m @param {number} residual
 */
function beyondAxes(model, ends, m, residual) {
  const most = reach(m.residual_arcsec, 1, 1);
  const cut = most > residual || model.some((v) => v !== null && (v < ends[0] || v > ends[1]));
  return cut
    ? ` Near the holding limit the model goes beyond the axes, with residuals of up to ${
      size(most)
    } ${state.unit}.`
    : "";
}

/** Readings in sight by level and way of the torque. */
function grouped() {
  const r = documentShown().readings;
  /** @type {Map<string, { level: number, branch: Branch, rows: number[] }>} */
  const groups = new Map();
  r.row.forEach((_, i) => {
    if (!visible(i)) return;
    const key = `${r.level[i]} ${r.branch[i]}`;
    const group = groups.get(key);
    if (group) group.rows.push(i);
    else groups.set(key, { level: r.level[i], branch: r.branch[i], rows: [i] });
  });
  return [...groups.values()];
}

/** What is selected stands out from the rest. @param {number[]} rows */
function parted(rows) {
  if (!state.selected.size) return [{ rows, opacity: 1, bars: true }];
  return [
    { rows: rows.filter((i) => !state.selected.has(i)), opacity: 0.16, bars: false },
    { rows: rows.filter((i) => state.selected.has(i)), opacity: 1, bars: true },
  ];
}

/** A line that cannot be seen, for what a pointer finds. @param {number[]} rows @returns {any[]} */
function hovered(rows) {
  const whole = documentShown();
  const r = whole.readings;
  const names = rows.map((i) =>
    `${whole.data.place} ${r.row[i]}, run ${safe(r.run[i])}<br>${
      safe(whole.data.settings[r.level[i]])
    }, ${BRANCHES[r.branch[i]].name}`
  );
  const residual = modelShown().residual_arcsec;
  return [["y", r.measured_arcsec, "measured"], ["y2", residual, "residual"]].map((
    [axis, values, what],
  ) => ({
    type: "scatter",
    mode: "lines",
    yaxis: axis,
    x: rows.map((i) => r.torque_Nm[i]),
    y: inUnit(rows.map((i) => /** @type {(number | null)[]} */ (values)[i])),
    text: names,
    line: { width: 0.1, color: "rgba(0,0,0,0)", simplify: false },
    hovertemplate: `%{x:.4g} N m: ${what} %{y:.3f} ${state.unit}<br>%{text}<extra></extra>`,
  }));
}

/** Of one run the model as it went, reading by reading. @param {Theme} t @param {number} s */
function lineOfRun(t, s) {
  const r = documentShown().readings;
  const rows = r.row.map((_, i) => i).filter(visible).slice(0, MOST_POINTS);
  return {
    type: "scatter",
    mode: "lines",
    x: rows.map((i) => r.torque_Nm[i]),
    y: rows.map((i) => (modelShown().model_arcsec[i] ?? NaN) * s),
    hoverinfo: "skip",
    line: { color: t.ink, width: 1.3 },
  };
}

/** Both ends of the bars about values. @param {readonly (number | null)[]} values @param {number[]} rows theirs */
function withBars(values, rows) {
  const u = documentShown().readings.u_arcsec;
  return values.flatMap((v, k) => {
    const half = u?.[rows[k]] ?? 0;
    return v === null ? [] : [v - half, v + half];
  });
}

/**
 * @param {Theme} t
 * @param {{ x: number[] | undefined, y: number[] | undefined }} ranges
 * @param {number} most of the residuals, arcsec
 */
function layoutOf(t, ranges, most) {
  const whole = documentShown();
  const floor = noiseOf();
  const reach = 1.12 * Math.max(most, 3 * (floor ?? 0), 1e-6) * scale();
  const torque = whole.columns.find((c) => c.key === "torque_Nm");
  return {
    uirevision: `${whole.opened} ${state.unit}`,
    selectionrevision: `${state.selected.size} ${Math.random()}`,
    selections: [],
    dragmode: matchMedia("(pointer: coarse)").matches ? false : "select",
    margin: { l: 58, r: 12, t: 10, b: 44 },
    xaxis: {
      title: torque ? `${torque.label} (${torque.unit})` : "torque (N m)",
      anchor: "y2",
      zeroline: true,
      range: ranges.x,
    },
    yaxis: {
      // What the full name takes is more than a plot on paper has.
      title: `${figure.height() < 300 ? "angle" : "elastic angle"} (${state.unit})`,
      domain: [0.4, 1],
      zeroline: true,
      range: ranges.y,
    },
    yaxis2: {
      title: `residual (${state.unit})`,
      domain: [0, 0.35],
      range: [-reach, reach],
      zeroline: true,
    },
    shapes: floor
      ? [{
        type: "rect",
        xref: "paper",
        x0: 0,
        x1: 1,
        yref: "y2",
        y0: -2 * floor * scale(),
        y1: 2 * floor * scale(),
        fillcolor: t.quiet,
        opacity: 0.13,
        line: { width: 0 },
        layer: "below",
      }]
      : [],
  };
}

/** Before there is an answer what is stated has to do; later the answer says what is known. @returns {number | null} */
function noiseOf() {
  const whole = documentShown();
  return whole.noise ? whole.noise.noise_floor_arcsec : median(whole.readings.u_arcsec ?? []);
}

/** @param {readonly (number | null)[]} values */
function median(values) {
  const known = values.filter((v) => v !== null).sort((a, b) => a - b);
  return known.length ? known[known.length >> 1] : null;
}
