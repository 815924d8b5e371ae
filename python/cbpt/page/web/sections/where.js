/** 6. Where it fails: the residual over two columns, the regions found, where contact is lost. */

/** @import { Theme } from "../lib/figure.js" */
/** @import { Region } from "../types.d.ts" */
import { called, columnChoice } from "../lib/columns.js";
import { bar, bodyOf, el, fill } from "../lib/dom.js";
import { Figure, safe } from "../lib/figure.js";
import { percent, plain, text } from "../lib/numbers.js";
import { BRANCHES } from "./readings.js";
import { residualCard } from "./residual.js";
import {
  columnOf,
  documentShown,
  hasBalls,
  modelShown,
  on,
  scale,
  select,
  size,
  state,
  visible,
} from "../lib/store.js";

const BINS = 16;
// Up to this many different values stand for themselves.
const MOST_LEVELS = 24;

/** @typedef {{ label: string, of: (i: number) => number | null, ticks: number[], texts: string[], edges: number[] }} Axis */

let across = "torque_Nm", up = "";
/** @type {Figure} */
let figure;
/** @type {HTMLElement} */
let choices;
/** @type {HTMLElement} */
let regions;

export function setUpWhere() {
  const place = bodyOf("where");
  choices = el("div", { class: "row no-print" });
  const plot = el("div", { id: "where-plot" });
  const note = el("span", { class: "small quiet" });
  regions = el("div", { class: "card", id: "regions" });
  fill(
    place,
    el(
      "div",
      { class: "grid" },
      el("div", { class: "grid two" }, el("div", { class: "card" }, choices, plot), regions),
      residualCard(),
    ),
  );
  figure = new Figure(plot, "where", "Map of the mean residual over two columns", build, {
    height: 400,
    paper: 340,
  });
  figure.under(note);
  on(["document"], () => {
    const keys = documentShown().columns.map((c) => c.key);
    if (!keys.includes(across)) across = keys[0];
    if (!keys.includes(up) || up === across) up = preferred(keys);
    drawChoices();
  });
  on(["document", "model"], () => {
    const { where } = documentShown();
    const regions = (where?.regions ?? []).length > 0, ofShown = where?.of === modelShown().key;
    fill(
      note,
      hasBalls() && "Hatched: at some of these readings balls have lost contact. ",
      regions &&
        (ofShown
          ? "Outlined: the regions listed here. "
          : "The regions listed here belong to the drive as stated; they are not outlined on another model. "),
      el("span", { class: "no-print" }, "A box drawn on the map selects readings."),
    );
  });
  on(["document", "unit"], drawRegions);
  on(["document", "model", "unit", "filter", "selection"], () => {
    figure.draw();
  });
  figure.onFirst = listen;
}

/** What the regions are about, else what varies. @param {string[]} keys */
function preferred(keys) {
  const named = (documentShown().where?.regions ?? []).flatMap((r) => Object.keys(r.region)).map(
    keyOf,
  );
  const order = [...named, "preload_N", "input_angle_deg", "branch", "time_s", ...keys];
  return order.find((k) => k !== across && keys.includes(k)) ?? across;
}

/** A region speaks of `direction`, the page of `branch`. @param {string} name */
function keyOf(name) {
  return name === "direction" ? "branch" : name;
}

function drawChoices() {
  const given = { columns: documentShown().columns };
  fill(
    choices,
    columnChoice({ ...given, id: "map-x", label: "Across", now: across }, (key) => {
      across = key;
      figure.draw();
    }),
    columnChoice({ ...given, id: "map-y", label: "Up", now: up }, (key) => {
      up = key;
      figure.draw();
    }),
  );
}

/** @param {string} key @returns {Axis} */
function axisOf(key) {
  const whole = documentShown();
  const column = whole.columns.find((c) => c.key === key);
  const raw = columnOf(key);
  const label = column ? called(column) : key;
  const values = [...new Set(raw.filter((v) => v !== null))];
  const named = column?.kind === "category" || values.some((v) => typeof v === "string");
  if (named || values.length <= MOST_LEVELS) {
    if (!named) values.sort((a, b) => Number(a) - Number(b));
    const place = new Map(values.map((v, k) => [v, k]));
    const texts = values.map((v) =>
      key === "branch"
        ? BRANCHES[/** @type {"up"} */ (v)].name.replace("torque ", "")
        : safe(typeof v === "number" ? plain(v) : v)
    );
    return {
      label,
      of: (i) => place.get(/** @type {any} */ (raw[i])) ?? null,
      ticks: values.map((_, k) => k),
      texts,
      edges: values.map(Number),
    };
  }
  const numbers = /** @type {number[]} */ (values);
  const low = Math.min(...numbers), high = Math.max(...numbers);
  const step = (high - low) / BINS;
  const ticks = Array.from({ length: BINS }, (_, k) => k);
  return {
    label,
    of: (i) =>
      raw[i] === null ? null : Math.min(BINS - 1, Math.floor((Number(raw[i]) - low) / step)),
    ticks,
    texts: ticks.map((k) => text(low + (k + 0.5) * step, 3)),
    edges: ticks.map((k) => low + (k + 0.5) * step),
  };
}

/** @param {Theme} t */
function build(t) {
  const whole = documentShown();
  const m = modelShown();
  const x = axisOf(across), y = axisOf(up);
  const blank = () => y.ticks.map(() => x.ticks.map(() => 0));
  const sums = blank(), count = blank(), parted = blank(), chosen = blank();
  whole.readings.row.forEach((_, i) => {
    const [a, b, v] = [x.of(i), y.of(i), m.residual_arcsec[i]];
    if (a === null || b === null || v === null || !visible(i)) return;
    sums[b][a] += v;
    count[b][a] += 1;
    const regime = whole.readings.regime[i];
    if (regime !== null && !whole.regimes_full[regime]) parted[b][a] += 1;
    if (state.selected.has(i)) chosen[b][a] += 1;
  });
  const s = scale();
  const mean = sums.map((line, b) =>
    line.map((v, a) => (count[b][a] ? (v / count[b][a]) * s : null))
  );
  // The colours keep the span of the model as stated, so that they fade as the error falls.
  const span = Math.max(...spans(x, y, s), 1e-9);
  const marks = (
    /** @type {number[][]} */ cells,
    /** @type {(b: number, a: number) => boolean} */ test,
  ) => cells.flatMap((line, b) => line.flatMap((_, a) => (test(b, a) ? [[a, b]] : [])));
  const hatched = marks(parted, (b, a) => parted[b][a] > 0);
  const ringed = marks(chosen, (b, a) => chosen[b][a] > 0);
  const ticks = (/** @type {Axis} */ axis) => {
    // As many as stand beside each other, of those across.
    const letters = Math.max(...axis.texts.map((words) => words.length), 1);
    const most = axis === x ? Math.max(3, (figure.area.clientWidth - 170) / (7 * letters + 8)) : 12;
    const step = Math.ceil(axis.ticks.length / Math.min(12, most));
    const shown = axis.ticks.filter((k) => k % step === 0);
    return { tickangle: 0, tickvals: shown, ticktext: shown.map((k) => axis.texts[k]) };
  };
  return {
    data: [
      {
        type: "heatmap",
        z: mean,
        x: x.ticks,
        y: y.ticks,
        xgap: 1,
        ygap: 1,
        zmin: -span,
        zmax: span,
        colorscale: t.diverging,
        colorbar: {
          title: { text: `mean residual<br>(${state.unit})`, font: { size: 11, color: t.quiet } },
          thickness: 11,
          outlinewidth: 0,
          len: 0.9,
          tickfont: { color: t.quiet },
        },
        customdata: count.map((line, b) =>
          line.map((n, a) => [n, parted[b][a], x.texts[a], y.texts[b]])
        ),
        hovertemplate: `${safe(x.label)}: %{customdata[2]}<br>${
          safe(y.label)
        }: %{customdata[3]}<br>mean %{z:+.3f} ${state.unit} of %{customdata[0]} readings${
          hasBalls() ? "<br>contact lost in %{customdata[1]}" : ""
        }<extra></extra>`,
      },
      {
        type: "scatter",
        mode: "lines",
        ...hatch(hatched),
        hoverinfo: "skip",
        line: { color: t.ink, width: 1 },
        opacity: 0.45,
      },
      {
        type: "scatter",
        mode: "markers",
        x: ringed.map((c) => c[0]),
        y: ringed.map((c) => c[1]),
        hoverinfo: "skip",
        marker: { symbol: "circle-open", size: 12, color: t.ink, line: { width: 2, color: t.ink } },
        selectedpoints: null,
      },
    ],
    layout: {
      margin: { l: 70, r: 6, t: 14, b: 50 },
      dragmode: matchMedia("(pointer: coarse)").matches ? false : "select",
      selections: [],
      xaxis: {
        title: x.label,
        ...ticks(x),
        range: [-0.5, x.ticks.length - 0.5],
        showgrid: false,
        zeroline: false,
      },
      yaxis: {
        title: y.label,
        automargin: true,
        ...ticks(y),
        range: [-0.5, y.ticks.length - 0.5],
        showgrid: false,
        zeroline: false,
      },
      ...outlines(t, x, y),
    },
  };
}

/** Three strokes across each cell, in one line. @param {number[][]} cells */
function hatch(cells) {
  /** @type {(number | null)[]} */
  const x = [];
  /** @type {(number | null)[]} */
  const y = [];
  for (const [a, b] of cells) {
    x.push(a - 0.5, a, null, a - 0.5, a + 0.5, null, a, a + 0.5, null);
    y.push(b, b + 0.5, null, b - 0.5, b + 0.5, null, b - 0.5, b, null);
  }
  return { x, y };
}

/** Mean residuals of the model as stated, cell by cell. @param {Axis} x @param {Axis} y @param {number} s */
function spans(x, y, s) {
  const whole = documentShown();
  /** @type {Map<string, [number, number]>} */
  const cells = new Map();
  whole.models[0].residual_arcsec.forEach((v, i) => {
    if (v === null) return;
    const key = `${x.of(i)} ${y.of(i)}`;
    const [sum, n] = cells.get(key) ?? [0, 0];
    cells.set(key, [sum + v, n + 1]);
  });
  return [...cells.values()].map(([sum, n]) => Math.abs(sum / n) * s);
}

/** The regions that speak of nothing but these two columns. @param {Theme} t @param {Axis} x @param {Axis} y */
function outlines(t, x, y) {
  const where = documentShown().where;
  // Regions of one model say nothing about the residual of another.
  if (where?.of !== modelShown().key) return {};
  /** @type {any[]} */
  const shapes = [];
  /** @type {any[]} */
  const annotations = [];
  where.regions.forEach((region, k) => {
    const ends = Object.fromEntries(
      Object.entries(region.region).map(([name, e]) => [keyOf(name), e]),
    );
    if (!Object.keys(ends).every((name) => name === across || name === up)) return;
    const [x0, x1] = reach(ends[across], x, across), [y0, y1] = reach(ends[up], y, up);
    shapes.push({ type: "rect", x0, x1, y0, y1, line: { color: t.ink, width: 2 } });
    annotations.push({
      x: x0,
      y: y1,
      xanchor: "left",
      yanchor: "top",
      text: `<b>${k + 1}</b>`,
      showarrow: false,
      bgcolor: t.ink,
      font: { size: 11, color: t.card },
      borderpad: 2,
    });
  });
  return { shapes, annotations };
}

/** @param {[number, number] | undefined} ends @param {Axis} axis @param {string} key @returns {[number, number]} */
function reach(ends, axis, key) {
  const most = axis.ticks.length - 0.5;
  if (!ends) return [-0.5, most];
  const ways = ["falling", "held", "rising"];
  const inside = axis.ticks.filter((k) => {
    const v = key === "branch" ? ways.indexOf(axis.texts[k]) - 1 : axis.edges[k];
    return v >= ends[0] - 1e-9 && v <= ends[1] + 1e-9;
  });
  return inside.length ? [inside[0] - 0.5, inside[inside.length - 1] + 0.5] : [-0.5, most];
}

function listen() {
  const area = /** @type {any} */ (figure.area);
  area.on("plotly_selected", (/** @type {any} */ event) => {
    if (!event?.range) return;
    const x = axisOf(across), y = axisOf(up);
    const inside = (/** @type {number | null} */ v, /** @type {number[]} */ ends) =>
      v !== null && v >= Math.min(...ends) && v <= Math.max(...ends);
    select(
      documentShown().readings.row.map((_, i) => i).filter((i) =>
        visible(i) && inside(x.of(i), event.range.x) && inside(y.of(i), event.range.y)
      ),
    );
  });
  area.on("plotly_deselect", () => select([]));
}

/** Readings of a region. @param {Region} region @returns {number[]} */
function readingsOf(region) {
  const whole = documentShown();
  const r = whole.readings;
  const way = { up: 1, down: -1, none: 0 };
  return r.row.map((_, i) => i).filter((i) =>
    Object.entries(region.region).every(([name, [low, high]]) => {
      const column = columnOf(keyOf(name));
      const v = name === "direction" ? way[r.branch[i]] : column?.[i];
      return typeof v !== "number" || (v >= low - 1e-6 && v <= high + 1e-6);
    }) && (!region.regime || whole.regimes[r.regime[i] ?? -1] === region.regime)
  );
}

function drawRegions() {
  const whole = documentShown();
  const list = whole.where?.regions ?? [];
  fill(
    regions,
    el("h3", {}, "Where the drive as stated fails"),
    list.length
      ? list.map((region, k) =>
        el(
          "div",
          { class: "region" },
          el(
            "p",
            {},
            el("b", {}, `${k + 1}. ${region.label}`),
            el("br"),
            `${
              percent(region.share_of_misfit)
            } of the misfit in ${region.readings} readings; bias ${
              size(region.bias_arcsec, true)
            } ${state.unit}, p = ${text(region.p_value, 2)}`,
          ),
          el("div", {
            class: "bar",
            role: "img",
            "aria-label": `${percent(region.share_of_misfit)} of the misfit`,
          }, bar(region.share_of_misfit)),
          el("button", {
            type: "button",
            class: "text small no-print",
            onclick: () => select(readingsOf(region)),
          }, "Select these readings"),
        )
      )
      : el("p", { class: "quiet" }, whole.reasons.where ?? "No region stands out from the rest."),
  );
}
