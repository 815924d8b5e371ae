/** 13. Export: the answer's JSON, the readings as CSV, the case file, plots, the command line. */

/** @import { Model } from "../types.d.ts" */
import { isLive } from "../lib/api.js";
import { announce, bodyOf, el, fill } from "../lib/dom.js";
import { saveFile } from "../lib/figure.js";
import { caseWith } from "../lib/casefile.js";
import { text } from "../lib/numbers.js";
import { documentShown, hasBalls, modelShown, on, scale, state } from "../lib/store.js";

export function setUpExport() {
  on(["document", "model", "unit"], draw);
}

function draw() {
  const whole = documentShown();
  const base = whole.data.name.replace(/\.[^.]*$/, "").replace(/[^\w.-]+/g, "_") || "readings";
  const m = modelShown();
  const case_ = caseWith(whole, m);
  /** @param {string} id @param {string} name @param {() => void} act @param {string} what @param {boolean} [disabled] */
  const button = (id, name, act, what, disabled = false) =>
    el("button", { type: "button", id, title: what, onclick: act, disabled }, name);
  fill(
    bodyOf("export"),
    el(
      "div",
      { class: "card stack" },
      el(
        "div",
        { class: "row no-print" },
        whole.answer &&
          button(
            "save-answer",
            "Answer (JSON)",
            () =>
              saveFile(
                `${base}_answer.json`,
                JSON.stringify(whole.answer, null, 1),
                "application/json",
              ),
            "what cbpt diagnose --json writes",
          ),
        button(
          "save-json",
          "Page (JSON)",
          () => saveFile(`${base}_page.json`, JSON.stringify(whole), "application/json"),
          "every number on this page",
        ),
        button(
          "save-csv",
          "Readings (CSV)",
          () => saveFile(`${base}_readings.csv`, csv(), "text/csv"),
          "with model and residual of the model shown",
        ),
        button(
          "save-case",
          "Case file (TOML)",
          () => case_ && saveFile(`${base}_case.toml`, case_, "application/toml"),
          case_ === null ? noCase(m) : "with the effects and refitted numbers of the model shown",
          case_ === null,
        ),
        el("button", { type: "button", id: "print", onclick: () => print() }, "Print"),
      ),
      el(
        "p",
        { class: "small quiet" },
        case_ === null
          ? `The readings are those of the model shown (${m.label}). ${noCase(m)}`
          : `Readings and case are those of the model shown (${m.label}).`,
        el(
          "span",
          { class: "no-print" },
          ` Every plot has its own SVG button.${
            isLive() ? "" : " The document is inside this file."
          }`,
        ),
      ),
      el("h3", { class: "minor" }, "The same from a command line"),
      commands(`${base}_case.toml`).map(([what, words, id]) =>
        el(
          "div",
          { class: "stack" },
          el("p", { class: "small quiet" }, what),
          el("pre", { id }, words),
          el(
            "button",
            { type: "button", class: "no-print", onclick: () => copy(words) },
            "Copy",
            el("span", { class: "visually-hidden" }, ` the command: ${what}`),
          ),
        )
      ),
      case_ !== null && el(
        "details",
        {},
        el("summary", {}, "Case file of the model shown"),
        el("pre", { id: "case-text" }, case_),
      ),
    ),
  );
}

/** Why there is no case file. @param {Model} m */
function noCase(m) {
  return `This model has no case file: ${m.why_no_case ?? "it was not fitted"}.`;
}

/**
 * This page, and the model that is shown, as commands.
 * @param {string} saved the case file with the effects in it, as it is saved above
 * @returns {[string, string, string][]}
 */
function commands(saved) {
  const whole = documentShown(), m = modelShown();
  const { case: stated, data, reading } = whole.command_words;
  /** @param {string[]} words */
  const line = (...words) => words.filter(Boolean).join(" ");
  /** @type {[string, string, string][]} */
  const found = [[
    whole.data.left_out
      ? `This page, but with the ${whole.data.left_out} readings that are left out here`
      : "This page",
    whole.command,
    "command",
  ]];
  if (m.key === "stated" || caseWith(whole, m) === null) return found;
  const zero = m.zero_arcsec
    ? `; the page subtracts the offset that fits best (${
      text(m.zero_arcsec * scale(), 3)
    } ${state.unit}), which compare states beside its error`
    : "";
  found.push([
    `The model shown, from the case file saved above${zero}`,
    line("cbpt compare", saved, data, reading),
    "command-of-model",
  ]);
  if (m.effects.length && m.effects.every((e) => /^\w+$/.test(e))) {
    const known = whole.library.map((e) => e.effect);
    const own = m.effects.some((e) => !known.includes(e));
    found.push([
      "The same effects fitted again; noise and start values are found anew, so the result may differ",
      line(
        "cbpt fit",
        // The case that is saved knows the own effect.
        own ? saved : stated,
        data,
        reading,
        "--with",
        ...m.effects,
        "--out case_with.toml",
      ),
      "command-of-fit",
    ]);
  }
  return found;
}

/** @param {string} words */
async function copy(words) {
  try {
    await navigator.clipboard.writeText(words);
    announce("Copied");
  } catch {
    announce("The browser does not allow this page to copy; select the text instead.");
  }
}

/** A row a reading, with the model shown beside it. */
function csv() {
  const whole = documentShown();
  const r = whole.readings;
  const m = modelShown();
  /** @type {[string, readonly unknown[] | null][]} */
  const columns = [
    [whole.data.place, r.row],
    ["run", r.run],
    ["time_s", r.time_s],
    ["torque_Nm", r.torque_Nm],
    ["preload_N", r.preload_N],
    ["input_angle_deg", r.input_angle_deg],
    ["temperature_degC", r.temperature_degC],
    ["cycle", r.cycle],
    ["direction", r.branch],
    // As they were read; the model is that of readings without the offsets of their runs.
    ["elastic_angle_arcsec", r.measured_arcsec.map((v, i) => v + r.zero_arcsec[i])],
    ["zero_of_run_arcsec", r.zero_arcsec.some((v) => v !== 0) ? r.zero_arcsec : null],
    ["u_elastic_angle_arcsec", r.u_arcsec],
    ["model_arcsec", m.model_arcsec],
    ["residual_arcsec", m.residual_arcsec],
    ["contacts", hasBalls() ? r.regime.map((k) => (k === null ? "" : whole.regimes[k])) : null],
  ];
  const there = columns.filter(([, values]) => values !== null);
  const lines = [there.map(([name]) => name).join(",")];
  r.row.forEach((_, i) => lines.push(there.map(([, values]) => cell(values?.[i])).join(",")));
  return `${lines.join("\n")}\n`;
}

/** A cell that a spreadsheet takes for a value, never for a formula. @param {unknown} value */
export function cell(value) {
  if (value === null || value === undefined) return "";
  if (typeof value === "number") return String(value);
  let words = String(value);
  if (/^[=+\-@\t\r]/.test(words) && !Number.isFinite(Number(words))) words = `'${words}`;
  return /[",\n\r]/.test(words) ? `"${words.replaceAll('"', '""')}"` : words;
}
