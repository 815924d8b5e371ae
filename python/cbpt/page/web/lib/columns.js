/** The columns of a table: what they are called, and a list to choose one from. */

import { el } from "./dom.js";

/** @typedef {{ key: string, label: string, unit?: string | null }} Column */

/** @param {Column} column */
export const called = (column) => column.unit ? `${column.label} (${column.unit})` : column.label;

/**
 * @param {{ id: string, label: string, now: string, columns: Column[] }} given now: the key chosen
 * @param {(key: string) => void} take
 */
export function columnChoice({ id, label, now, columns }, take) {
  const options = columns.map((c) =>
    el("option", { value: c.key, selected: c.key === now }, called(c))
  );
  const list = el("select", { id, onchange: (e) => take(e.target.value) }, options);
  return el("label", { class: "inline" }, label, list);
}
