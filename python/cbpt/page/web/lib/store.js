/**
 * What the page shows now, in one place: the document, the model, the selection, the filters.
 *
 * Sections listen to the topics they draw from; whoever changes something tells its topic.
 * Topics: document (another one), models (one more), model (another shown), selection, filter, unit,
 * table (its section has come after the rest of the document).
 */

/** @import { Model, PageDocument } from "../types.d.ts" */
import { isLive, showsFiles } from "./api.js";
import { text } from "./numbers.js";

/** @typedef {"document" | "models" | "model" | "selection" | "filter" | "unit" | "table"} Topic */

/** @type {{ topics: Topic[], act: () => void }[]} */
const listeners = [];
/** How many of them were there when something was told last. */
let reached = 0;

/** @type {{ document: PageDocument | null, model: string, unit: string, selected: Set<number>,
 *   hidden: Set<number>, run: number | null }} */
export const state = {
  document: null,
  model: "stated",
  unit: "arcsec",
  selected: new Set(),
  hidden: new Set(),
  run: null,
};

/** @param {Topic[]} topics @param {() => void} act */
export function on(topics, act) {
  listeners.push({ topics, act });
}

/** Whoever listens to several of them is told once. @param {Topic[]} told */
export function tell(...told) {
  tellFrom(0, told);
}

/** Those who listen only since something was told. @param {Topic[]} told */
export function tellNewcomers(...told) {
  tellFrom(reached, told);
}

/** @param {number} first @param {Topic[]} told */
function tellFrom(first, told) {
  reached = listeners.length;
  for (const { topics, act } of listeners.slice(first)) {
    if (topics.some((topic) => told.includes(topic))) act();
  }
}

/** @returns {PageDocument} */
export function documentShown() {
  if (!state.document) throw new Error("no document");
  return state.document;
}

/** Whether the reducer has balls, grooves and contacts, or is known by its stiffness alone. */
export function hasBalls() {
  return documentShown().case.kind === "ball_drive";
}

/** @param {PageDocument} next */
export function setDocument(next) {
  const last = state.document;
  const same = last !== null && last.opened === next.opened;
  showsFiles(next.opened ?? 0);
  if (same) keepModels(last, next);
  state.document = next;
  if (!same) {
    state.selected = new Set();
    state.hidden = new Set();
    state.run = null;
    if (!isLive()) state.unit = next.unit;
  }
  if (!same || !modelOf(state.model)) state.model = first(next);
  tell("document");
}

/** A report begins with what was found, the workbench with what is known. @param {PageDocument} whole */
function first(whole) {
  return isLive() ? "stated" : whole.answer_key ?? "stated";
}

/**
 * What was fitted for the page before the rest of the document was known stays.
 * @param {PageDocument} last @param {PageDocument} next
 */
function keepModels(last, next) {
  const known = new Set(next.models.map((m) => m.key));
  for (const model of last.models.filter((m) => !known.has(m.key))) {
    next.models.push(model);
    next.curves.forEach((line, k) => {
      line.angle_arcsec[model.key] = last.curves[k]?.angle_arcsec[model.key] ?? null;
    });
  }
}

/** @param {string} key @returns {Model | undefined} */
export function modelOf(key) {
  return state.document?.models.find((m) => m.key === key);
}

/** The model that is shown. @returns {Model} */
export function modelShown() {
  return modelOf(state.model) ?? documentShown().models[0];
}

/** Show a model. @param {string} key @param {Topic[]} more what else has changed with it */
export function setModel(key, ...more) {
  if (!modelOf(key)) throw new Error(`no model ${key}`);
  state.model = key;
  tell("model", ...more);
}

/** @param {Iterable<number>} rows indices of readings */
export function select(rows) {
  state.selected = new Set(rows);
  tell("selection");
}

/** The unit shown, in arcsec. */
function unit() {
  return documentShown().units[state.unit];
}

/** An arcsec, the unit of the document's angles, in the unit shown. */
export function scale() {
  return 1 / unit();
}

/**
 * An error or another angle of the document in the unit shown, with three digits that can be seen.
 * @param {number | null | undefined} arcsec @param {boolean} [signed]
 */
export function size(arcsec, signed = false) {
  if (arcsec === null || arcsec === undefined) return "–";
  return `${signed && arcsec > 0 ? "+" : ""}${text(arcsec * scale(), 3)}`;
}

/** As many decimals in the unit shown as those of arcsec stand for. @param {number} ofArcsec */
export function decimals(ofArcsec) {
  return Math.max(0, ofArcsec + Math.round(Math.log10(unit())));
}

/** @param {readonly (number | null)[]} values @returns {(number | null)[]} */
export function inUnit(values) {
  const s = scale();
  return s === 1 ? [...values] : values.map((v) => (v === null ? null : v * s));
}

/** A column of the readings by its key. @param {string} key @returns {(number | string | null)[]} */
export function columnOf(key) {
  return /** @type {any} */ (documentShown().readings)[key];
}

/** Whether a reading passes the filters. @param {number} i */
export function visible(i) {
  const r = documentShown().readings;
  return !state.hidden.has(r.level[i]) && (state.run === null || r.run_index[i] === state.run);
}
