/**
 * 9. Your own effect: an expression with parameters, checked as it is typed, fitted like the others.
 *
 * What is a parameter is seen from the expression: a name that is neither variable nor function.
 */

/** @import { OwnEffect, OwnParameter } from "../types.d.ts" */
import { diagnoseWithOwn } from "./job.js";
import { isLive, post } from "../lib/api.js";
import { afterPause, announce, bodyOf, byId, el, fill, setUsable, usable } from "../lib/dom.js";
import { redefined, show, take, told } from "../lib/models.js";
import { text } from "../lib/numbers.js";
import { parameters as sizesOf } from "./candidates.js";
import { documentShown, hasBalls, modelShown, on, setModel } from "../lib/store.js";

const BLANK = {
  id: "my_effect",
  port: "series",
  expression: "a * torque_Nm",
  parameters: [{ name: "a", unit: "rad/(N m)", start: 1e-6, min: -1e-3, max: 1e-3 }],
};

/** @type {OwnEffect} */
let effect = structuredClone(BLANK);
/**
 * Every parameter that there has been with these files, the draft's among them: an expression that
 * is put back has its numbers again.
 * @type {Map<string, OwnParameter>}
 */
let seen = new Map();
/** @type {string | null} */
let of = null;

export function setUpOwn() {
  on(["document"], () => {
    const whole = documentShown();
    const now = `${whole.opened} ${!!whole.answer}`;
    if (of === now) return;
    of = now;
    effect = kept() ?? structuredClone(whole.own.draft ?? BLANK);
    seen = new Map(effect.parameters.map((p) => [p.name, p]));
    draw();
  });
  on(["model"], drawFound);
}

/** What was written last is kept in the browser, by case and table: a reload forgets nothing. */
function keyOfFiles() {
  const { case: of_, data } = documentShown();
  return `cbpt own effect ${of_.sha256.slice(0, 16)} ${data.sha256.slice(0, 16)}`;
}

/** @returns {OwnEffect | null} */
function kept() {
  try {
    return isLive() ? JSON.parse(localStorage.getItem(keyOfFiles()) ?? "null") : null;
  } catch {
    return null;
  }
}

function keep() {
  try {
    localStorage.setItem(keyOfFiles(), JSON.stringify(effect));
  } catch {
    // A browser that keeps nothing still has the editor.
  }
}

/** @type {HTMLElement} */
let mistake;
/** @type {HTMLElement} */
let list;
/** @type {HTMLElement} */
let found;
/** @type {HTMLButtonElement} */
let fit;

function draw() {
  const whole = documentShown();
  const place = bodyOf("own");
  const draft = whole.own.draft, words = whole.command_words;
  // An invitation to write one is nothing for paper.
  byId("own").classList.toggle("no-print", !draft);
  const told_ = draft
    ? el(
      "p",
      {},
      "A draft of an effect that the library does not hold, derived from these readings: ",
      el(
        "b",
        {},
        `held-out error with it ${
          text(whole.answer?.unknown?.expression_held_out_rmse_arcsec, 3)
        } arcsec.`,
      ),
    )
    : el(
      "p",
      { class: "quiet" },
      "Write an effect that the library does not hold as a formula in the columns of the table and the numbers of the drive. All quantities are in SI units and radians.",
    );
  if (!isLive()) {
    return fill(
      place,
      el(
        "div",
        { class: "card stack" },
        told_,
        draft?.toml && el("pre", { id: "draft" }, draft.toml),
        el(
          "p",
          { class: "small quiet" },
          `The workbench ${
            draft ? "lets you edit the draft" : "has an editor"
          }, checks the formula as you type and fits it: `,
          el(
            "code",
            {},
            ["cbpt workbench", words.case, words.data, words.reading].join(" ").trim(),
          ),
          el("br"),
          draft
            ? "Or paste the draft into the case file and add its id after "
            : "Or write an [[effect]] into the case file and add its id after ",
          el("code", {}, "--with"),
          ".",
        ),
      ),
    );
  }
  const expression = el("textarea", {
    class: "expression",
    id: "own-expression",
    spellcheck: "false",
    autocapitalize: "off",
    rows: 3,
    maxlength: 1000,
    "aria-describedby": "own-mistake",
    "data-field": "expression",
    oninput: (e) => {
      effect.expression = e.target.value;
      if (matchParameters()) drawParameters();
      changed();
    },
  }, effect.expression);
  mistake = el("div", {
    class: "mistake",
    id: "own-mistake",
    role: "status",
    "aria-live": "polite",
  });
  list = el("div", { class: "own-parameters" });
  found = el("div", { id: "own-found" });
  fit = el("button", { type: "button", class: "main", id: "own-fit", onclick: fitted }, "Fit it");
  fill(
    place,
    el(
      "div",
      { class: "grid two" },
      el(
        "div",
        { class: "card stack" },
        told_,
        el(
          "div",
          { class: "grid halves" },
          el(
            "label",
            { class: "field" },
            el("span", {}, "Name"),
            el("input", {
              id: "own-id",
              value: effect.id,
              spellcheck: "false",
              "aria-describedby": "own-mistake",
              "data-field": "id",
              oninput: (e) => ((effect.id = e.target.value), changed()),
            }),
          ),
          el(
            "label",
            { class: "field" },
            el("span", {}, "Where it acts"),
            el(
              "select",
              { id: "own-port", onchange: (e) => ((effect.port = e.target.value), changed()) },
              whole.own.ports.map((p) =>
                el(
                  "option",
                  { value: p.key, selected: p.key === effect.port },
                  `${p.key}: ${p.meaning}`,
                )
              ),
            ),
          ),
        ),
        el("label", { class: "field" }, el("span", {}, "Expression"), expression),
        mistake,
        list,
        el("div", { class: "row" }, fit, found),
      ),
      el(
        "div",
        { class: "card" },
        el("h3", {}, "Variables and functions"),
        el(
          "ul",
          { class: "plain small" },
          whole.own.variables.filter((v) => hasBalls() || v.name !== "planet_turn").map((v) =>
            el(
              "li",
              {},
              el("button", {
                type: "button",
                class: "text mono",
                onclick: () => insert(expression, v.name),
              }, v.name),
              ` ${v.meaning}`,
            )
          ),
          el(
            "li",
            {},
            el("code", {}, "+ − * / ^  pi  sin cos tan atan tanh exp log sqrt abs sign min max"),
          ),
        ),
      ),
    ),
  );
  matchParameters();
  drawParameters();
  changed();
}

/** @param {HTMLTextAreaElement} field @param {string} name */
function insert(field, name) {
  field.setRangeText(name, field.selectionStart, field.selectionEnd, "end");
  field.focus();
  field.dispatchEvent(new Event("input"));
}

/** Names of the expression that are parameters; true where they are others than before. */
function matchParameters() {
  const known = new Set(["pi", ...documentShown().own.variables.map((v) => v.name)]);
  const names = [...new Set(effect.expression.match(/[A-Za-z_]\w*(?!\w*\s*\()/g) ?? [])].filter((
    n,
  ) => !known.has(n) && !/^[eE]\d*$/.test(n));
  if (names.join() === effect.parameters.map((p) => p.name).join()) return false;
  effect.parameters = names.map((name) => {
    const p = seen.get(name) ?? begun(name, names[0] === name);
    seen.set(name, p);
    return p;
  });
  return true;
}

/**
 * A new parameter: where it may begin and how far it may go follows from its place in the
 * expression. The first is taken for the size of the effect.
 * @param {string} name @param {boolean} size @returns {OwnParameter}
 */
function begun(name, size) {
  const stands = (/** @type {string} */ before) =>
    new RegExp(`${before}[\\s(+-]*${name}\\b`).test(effect.expression);
  if (stands("\\^")) return { name, unit: "", start: 1, min: 0.2, max: 3 };
  if (stands("time_s\\s*/")) return { name, unit: "s", start: 60, min: 1, max: 10000 };
  const start = !size ? 1 : effect.port === "load" ? 0.1 : 1e-6;
  return { name, unit: "", start, min: null, max: null };
}

/**
 * What is typed of a number, null where nothing is; what is no number stays as it was typed, so that
 * it is refused and not left out.
 * @param {string} typed
 */
function numberOf(typed) {
  const plain = typed.replace(/^\u2212/, "-");
  if (plain === "") return null;
  const read = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
  return Number.isFinite(read) ? read : typed;
}

function drawParameters() {
  /** @param {OwnParameter} p @param {"unit" | "start" | "min" | "max"} part */
  const field = (p, part) =>
    el("input", {
      value: p[part] ?? "",
      inputmode: part === "unit" ? "text" : "decimal",
      "aria-label": `${part} of ${p.name}`,
      "aria-describedby": "own-mistake",
      "data-field": `parameters.${p.name}.${part}`,
      oninput: (e) => {
        const typed = e.target.value.trim();
        if (part === "unit") p.unit = typed;
        else p[part] = numberOf(typed);
        changed();
      },
    });
  fill(
    list,
    effect.parameters.length > 0 && el(
      "div",
      {
        class: "scroll",
        tabindex: "0",
        role: "region",
        "aria-label": "Parameters of the expression",
      },
      el(
        "table",
        {},
        el("caption", { class: "visually-hidden" }, "Parameters of the expression"),
        el(
          "thead",
          {},
          el(
            "tr",
            {},
            ["parameter", "unit", "start", "minimum", "maximum"].map((h) =>
              el("th", { scope: "col" }, h)
            ),
          ),
        ),
        el(
          "tbody",
          {},
          effect.parameters.map((p) =>
            el(
              "tr",
              {},
              el("th", { scope: "row", class: "mono" }, p.name),
              (/** @type {const} */ (["unit", "start", "min", "max"])).map((part) =>
                el("td", {}, field(p, part))
              ),
            )
          ),
        ),
      ),
    ),
  );
}

let asked = 0;
/** Whether the check has found that it can be fitted, and whether it is being fitted. */
let fits = false, fitting = false;

/** What was said of another text no longer stands beside this one. */
function changed() {
  asked++;
  fits = false;
  setFit();
  mistake.classList.remove("fine");
  mistake.textContent = "";
  mark(null);
  check();
}

/**
 * Mark the field that a mistake is in; `parameters.a` is all that is typed of `a`.
 * @param {string | null} field
 */
function mark(field) {
  for (const input of byId("own").querySelectorAll("[data-field]")) {
    const meant = field && `${input.getAttribute("data-field")}.`.startsWith(`${field}.`);
    if (meant) input.setAttribute("aria-invalid", "true");
    else input.removeAttribute("aria-invalid");
  }
}

const check = afterPause(120, async () => {
  const mine = ++asked;
  try {
    const answer = await post("own/check", effect);
    if (mine !== asked) return;
    fits = answer.ok;
    setFit();
    mistake.classList.toggle("fine", answer.ok);
    mistake.textContent = answer.ok
      ? ["✓ can be fitted", ...answer.notes].join("\n")
      : pointed(answer);
    mark(answer.field);
  } catch (error) {
    if (mine === asked) {
      mistake.textContent = error instanceof Error ? error.message : String(error);
    }
  }
});

/** The message, under a mark at its column where there is one. @param {{ message: string, column?: number | null }} answer */
function pointed(answer) {
  if (!answer.column) return answer.message;
  const before = effect.expression.slice(0, answer.column - 1);
  const line = before.split("\n").length - 1;
  const column = answer.column - 1 - (before.lastIndexOf("\n") + 1);
  return `${effect.expression.split("\n")[line]}\n${" ".repeat(column)}^ ${answer.message}`;
}

function setFit() {
  setUsable(fit, fits && !fitting);
}

async function fitted() {
  if (!usable(fit)) return;
  fitting = true;
  setFit();
  fill(found, el("span", { class: "quiet" }, "fitting …"));
  const { id } = effect;
  try {
    const answer = await post("own/fit", effect);
    redefined(id);
    keep();
    take(answer);
    setModel(answer.model.key, "models");
    announce(told());
  } catch (error) {
    // Beside the editor, where one looks; in place of what the check said.
    fill(found);
    mistake.classList.remove("fine");
    mistake.textContent = error instanceof Error ? error.message : String(error);
  } finally {
    fitting = false;
    setFit();
  }
}

/** Whether the diagnosis has weighed an effect. @param {string} effect */
function weighed(effect) {
  const { candidates, library } = documentShown();
  return [...candidates, ...library].some((c) => c.effect === effect);
}

function drawFound() {
  const m = modelShown();
  if (!found || m.role !== "own") return;
  fill(
    found,
    el("b", {}, told()),
    sizesOf(m),
    el("button", { type: "button", class: "text", onclick: () => show([]) }, "as stated again"),
    m.effects.some((e) => !weighed(e)) &&
      el(
        "button",
        { type: "button", class: "main", id: "diagnose-own", onclick: diagnoseWithOwn },
        "Diagnose again with it",
      ),
  );
}
