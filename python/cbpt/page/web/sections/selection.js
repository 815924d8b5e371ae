/**
 * Rows of the table by choice: those inside a box drawn in a plot, or with some values of a column;
 * listed one by one, and in the workbench left out or kept alone, with the diagnosis repeated.
 */

/** @import { MapColumn } from "../types.d.ts" */
import { get, handOver, isLive, tellAtOnce } from "../lib/api.js";
import { called, columnChoice } from "../lib/columns.js";
import { byId, el, fill, table, trouble } from "../lib/dom.js";
import { nameOf } from "../lib/names.js";
import { fixed, plain } from "../lib/numbers.js";
import {
  columnOf,
  decimals,
  documentShown,
  hasBalls,
  modelShown,
  on,
  scale,
  select,
  setDocument,
  state,
} from "../lib/store.js";
import { BRANCHES } from "./readings.js";

const ROWS_SHOWN = 200;
/** A column of no more values than this is chosen from by value, else by a range. */
const MOST_VALUES = 24;

let by = "";
/** @type {HTMLElement} */
let choice;
/** @type {HTMLElement} */
let chosen;

export function setUpSelection() {
  choice = el("div", { class: "row no-print", id: "choose-rows" });
  chosen = el("div", { id: "selection" });
  fill(byId("rows"), choice, chosen);
  on(["document"], drawChoice);
  on(["document", "model", "unit", "selection"], drawSelection);
}

/** A column, and which of its values. */
function drawChoice() {
  const { columns, data } = documentShown();
  const out = data.left_out ?? 0;
  const column = columns.find((c) => c.key === by) ??
    columns.find((c) => c.key === "preload_N") ?? columns[0];
  by = column?.key ?? "";
  fill(
    choice,
    column &&
      columnChoice({ id: "rows-by", label: "Select readings by", now: by, columns }, (key) => {
        by = key;
        drawChoice();
      }),
    column && valuesOf(column),
    isLive() && out > 0 && el(
      "button",
      { type: "button", id: "all-again", onclick: () => leaveOut([]) },
      `${out} readings left out: take all again`,
    ),
  );
}

/** One value, or a range with its button. @param {MapColumn} column */
function valuesOf(column) {
  const values = columnOf(column.key);
  const found = [...new Set(values)].filter((v) => v !== null);
  if (found.length <= MOST_VALUES || column.kind === "category") {
    const sorted = found.sort((a, b) =>
      typeof a === "number" && typeof b === "number" ? a - b : String(a) < String(b) ? -1 : 1
    );
    return el(
      "select",
      {
        id: "rows-value",
        "aria-label": called(column),
        onchange: (e) => pick(values, (v) => e.target.value !== "" && v === sorted[e.target.value]),
      },
      el("option", { value: "" }, "choose"),
      sorted.map((v, k) => el("option", { value: k }, told(column, v))),
    );
  }
  const numbers = /** @type {number[]} */ (found);
  /** @param {string} id @param {string} label @param {number} value */
  const end = (id, label, value) => /** @type {HTMLInputElement} */ (el("input", {
    id,
    type: "number",
    step: "any",
    "aria-label": `${called(column)} ${label}`,
    value: plain(value),
  }));
  const s = column.key === "measured_arcsec" ? scale() : 1;
  const from = end("rows-from", "from", s * numbers.reduce((a, b) => Math.min(a, b)));
  const to = end("rows-to", "to", s * numbers.reduce((a, b) => Math.max(a, b)));
  return [
    "from",
    from,
    "to",
    to,
    el("button", {
      type: "button",
      id: "rows-select",
      onclick: () =>
        pick(
          values,
          (v) => typeof v === "number" && s * v >= Number(from.value) && s * v <= Number(to.value),
        ),
    }, "Select"),
  ];
}

/** @param {MapColumn} column @param {string | number} value */
function told(column, value) {
  if (column.key === "branch") return BRANCHES[/** @type {keyof BRANCHES} */ (value)].name;
  return typeof value === "number" ? plain(value) : value;
}

/** @param {(string | number | null)[]} values @param {(value: string | number | null) => boolean} wanted */
function pick(values, wanted) {
  select(values.flatMap((v, i) => wanted(v) ? [i] : []));
}

/** The readings selected, row by row. */
function drawSelection() {
  const place = byId("selection");
  const whole = documentShown();
  const r = whole.readings;
  if (!state.selected.size) return fill(place);
  const rows = [...state.selected].sort((a, b) => a - b);
  const m = modelShown();
  const s = scale();
  const more = whole.columns.filter((c) =>
    ["preload_N", "input_angle_deg", "time_s", "temperature_degC"].includes(c.key)
  );
  const bias = rows.reduce((sum, i) => sum + (m.residual_arcsec[i] ?? 0), 0) / rows.length;
  fill(
    place,
    el(
      "div",
      { class: "row between" },
      el(
        "h3",
        { id: "selected-count" },
        `${rows.length} readings selected, the others pale; mean residual ${
          fixed(bias * s, decimals(2), true)
        } ${state.unit}`,
      ),
      el(
        "span",
        { class: "row" },
        isLive() && el(
          "button",
          { type: "button", id: "leave-out", onclick: () => leaveOut(rows) },
          "Leave these out and diagnose again",
        ),
        isLive() && rows.length < r.row.length && el(
          "button",
          {
            type: "button",
            id: "keep-alone",
            onclick: () => leaveOut(r.row.map((_, i) => i).filter((i) => !state.selected.has(i))),
          },
          "Keep only these and diagnose again",
        ),
        el(
          "button",
          { type: "button", id: "clear-selection", onclick: () => select([]) },
          "Clear the selection",
        ),
      ),
    ),
    table(
      "Readings selected",
      [
        whole.data.place,
        "run",
        ...["torque_Nm", ...more.map((c) => c.key)].map((k) => ({ text: nameOf(k), number: true })),
        "direction",
        { text: `measured (${state.unit})`, number: true },
        {
          text: `residual (${state.unit})`,
          number: true,
        },
        ...(hasBalls() ? ["contacts"] : []),
      ],
      rows.slice(0, ROWS_SHOWN).map((i) => [
        r.row[i],
        r.run[i],
        plain(r.torque_Nm[i]),
        ...more.map((c) => plain(/** @type {number[]} */ (columnOf(c.key))[i])),
        BRANCHES[r.branch[i]].name.replace("torque ", ""),
        fixed(r.measured_arcsec[i] * s, decimals(3)),
        fixed((m.residual_arcsec[i] ?? NaN) * s, decimals(3), true),
        ...(hasBalls() ? [whole.regimes[r.regime[i] ?? -1] ?? ""] : []),
      ]),
    ),
    rows.length > ROWS_SHOWN &&
      el("p", { class: "small quiet" }, `The first ${ROWS_SHOWN} are listed; the CSV has all.`),
  );
}

/** Go on without some readings, or with all again. @param {number[]} rows */
async function leaveOut(rows) {
  try {
    setDocument(
      await handOver(async () => {
        await tellAtOnce("leave_out", { rows });
        return await get("document");
      }),
    );
  } catch (error) {
    trouble(error instanceof Error ? error.message : String(error));
  }
}
