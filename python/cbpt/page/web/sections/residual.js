/**
 * The residual of the model shown against any column of the table, coloured by any other: what the
 * eye finds first. It stands in the section that says where the model fails.
 */

/** @import { Theme } from "../lib/figure.js" */
import { called, columnChoice } from "../lib/columns.js";
import { el, fill } from "../lib/dom.js";
import { Figure, safe, thin } from "../lib/figure.js";
import { plain } from "../lib/numbers.js";
import { columnOf, documentShown, inUnit, modelShown, on, state, visible } from "../lib/store.js";

/** The place of a reading in the table, which no column has. */
const ORDER = "order";
/** More values than this are coloured along a ramp. */
const MOST_GROUPS = 8;
const MOST_DRAWN = 1500;

let against = "", by = "";
/** @type {Figure} */
let figure;
/** @type {HTMLElement} */
let choices;

/** @returns {HTMLElement} the card */
export function residualCard() {
  choices = el("div", { class: "row no-print" });
  const plot = el("div", { id: "residual-plot" });
  const card = el("div", { class: "card" }, el("h3", {}, "The residual, reading by reading"));
  card.append(choices, plot);
  figure = new Figure(plot, "residual", "Residual of each reading against a column", build, {
    height: 340,
    paper: 260,
  });
  figure.under(el("span", { class: "small quiet" }));
  on(["document"], () => {
    const keys = columns().map((c) => c.key);
    if (!keys.includes(against)) against = keys.includes("time_s") ? "time_s" : ORDER;
    if (!keys.includes(by)) by = keys.includes("preload_N") ? "preload_N" : ORDER;
    drawChoices();
  });
  on(["document", "model", "unit", "filter", "selection"], () => figure.draw());
  return card;
}

function columns() {
  return [...documentShown().columns, { key: ORDER, label: "order in the table", unit: "" }];
}

/** @param {string} key @returns {(string | number | null)[]} */
function valuesOf(key) {
  return key === ORDER ? documentShown().readings.row.map((_, i) => i + 1) : columnOf(key);
}

/** @param {string} key */
function named(key) {
  const column = columns().find((c) => c.key === key);
  return column ? called(column) : key;
}

function drawChoices() {
  const given = { columns: columns() };
  fill(
    choices,
    columnChoice({ ...given, id: "residual-x", label: "Against", now: against }, (key) => {
      against = key;
      figure.draw();
    }),
    columnChoice({ ...given, id: "residual-colour", label: "coloured by", now: by }, (key) => {
      by = key;
      figure.draw();
    }),
  );
}

/** @param {Theme} t */
function build(t) {
  const { readings } = documentShown();
  const residual = modelShown().residual_arcsec;
  const x = valuesOf(against), colour = valuesOf(by);
  const every = readings.row.map((_, i) => i).filter((i) =>
    visible(i) && residual[i] !== null && x[i] !== null
  );
  const place = x.every((v) => typeof v === "number") ? x : null;
  const rows = thin(every, /** @type {number[]} */ (place ?? every), residual, MOST_DRAWN);
  const found = [...new Set(rows.map((i) => colour[i]))];
  const dots = (/** @type {number[]} */ of, /** @type {any} */ marker) => ({
    type: "scatter",
    mode: "markers",
    x: of.map((i) => place ? x[i] : safe(x[i])),
    y: inUnit(of.map((i) => residual[i])),
    marker: {
      size: 5,
      opacity: of.map((i) => !state.selected.size || state.selected.has(i) ? 0.9 : 0.2),
      ...marker,
    },
    hovertemplate: `${safe(named(against))} %{x}: %{y:.3f} ${state.unit}<extra></extra>`,
  });
  const inGroups = found.length <= MOST_GROUPS || found.some((v) => typeof v === "string");
  const data = inGroups
    ? found.sort(inOrder).map((value, k) => ({
      ...dots(rows.filter((i) => colour[i] === value), { color: t.levels(found.length)[k] }),
      name: safe(`${named(by)} ${typeof value === "number" ? plain(value) : value}`),
    }))
    : [dots(rows, {
      color: rows.map((i) => colour[i]),
      colorscale: t.levels(5).map((c, k) => [k / 4, c]),
      colorbar: { title: { text: safe(named(by)), side: "right" }, thickness: 11, outlinewidth: 0 },
    })];
  return {
    data,
    layout: {
      showlegend: inGroups,
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 11 } },
      margin: { l: 58, r: 12, t: 10, b: 44 },
      xaxis: { title: safe(named(against)), ...(place ? {} : { type: "category" }) },
      yaxis: { title: `residual (${state.unit})`, zeroline: true },
    },
  };
}

/** @param {string | number | null} a @param {string | number | null} b */
function inOrder(a, b) {
  return typeof a === "number" && typeof b === "number" ? a - b : String(a) < String(b) ? -1 : 1;
}
