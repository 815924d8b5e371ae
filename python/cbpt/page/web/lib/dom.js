/**
 * Elements without markup in strings: every text from a file goes through a text node, so that a
 * name such as `<script>` is shown and never read as markup.
 */

/** @import { Child } from "./page.d.ts" */
/** @typedef {Record<string, string | number | boolean | null | undefined | ((event: any) => void)>} Attributes */

const SVG = "http://www.w3.org/2000/svg";

/**
 * An HTML element.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Attributes} [attributes] `on...` with a function listens; false and null are left out
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  dress(node, attributes);
  append(node, children);
  return node;
}

/**
 * An SVG element.
 * @template {keyof SVGElementTagNameMap} K
 * @param {K} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {SVGElementTagNameMap[K]}
 */
export function svg(tag, attributes = {}, ...children) {
  const node = /** @type {SVGElementTagNameMap[K]} */ (document.createElementNS(SVG, tag));
  dress(node, attributes);
  append(node, children);
  return node;
}

/** @param {Element} node @param {Attributes} attributes */
function dress(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : String(value));
  }
}

/** @param {Element} node @param {Child[]} children */
function append(node, children) {
  const flat = /** @type {Child[]} */ (/** @type {any[]} */ (children).flat(Infinity));
  for (const child of flat) {
    if (child === null || child === undefined || child === false) continue;
    node.append(child instanceof Node ? child : String(child));
  }
}

/**
 * The element with an id; a page without it is a mistake of this page.
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const node = document.getElementById(id);
  if (!node) throw new Error(`no #${id}`);
  return node;
}

/**
 * The place for the content of a section.
 * @param {string} section
 * @returns {HTMLElement}
 */
export function bodyOf(section) {
  const node = byId(section).querySelector(".body");
  if (!(node instanceof HTMLElement)) throw new Error(`no body in #${section}`);
  return node;
}

const CONTROLS = "button, select, input, textarea, summary, [tabindex]";

/** The control that had the focus when its place was filled. @type {{ node: Element, had: Element, sign: string } | null} */
let lost = null;

/**
 * Put content in the place of what an element has. The focus stays on the control that has it,
 * where the same one is there again: who goes by keyboard would else begin at the top.
 * @param {Element} node
 * @param {...Child} children
 */
export function fill(node, ...children) {
  const had = node.contains(document.activeElement) ? document.activeElement : null;
  if (had) {
    lost = { node, had, sign: signOf(had) };
    queueMicrotask(focusAgain);
  }
  node.replaceChildren();
  append(node, children);
}

/** Once all is drawn: to set the focus the browser lays out the whole page, and again after more. */
function focusAgain() {
  if (!lost || document.activeElement !== document.body) return;
  const { node, had, sign } = lost;
  lost = null;
  const again = had.isConnected
    ? had
    : [...node.querySelectorAll(CONTROLS)].find((e) => signOf(e) === sign);
  if (again instanceof HTMLElement) again.focus({ preventScroll: true });
}

/** What a control is known by. @param {Element} control */
function signOf(control) {
  const { effect, key } = /** @type {HTMLElement} */ (control).dataset;
  const name = control.id || effect || key || control.getAttribute("aria-label");
  return `${control.tagName} ${name || control.textContent}`;
}

/**
 * Whether a button may be used: said, not by `disabled`, which would take the focus from it. What it
 * does has to ask `usable` first.
 * @param {Element} button @param {boolean} may
 */
export function setUsable(button, may) {
  button.setAttribute("aria-disabled", String(!may));
}

/** @param {Element} button */
export function usable(button) {
  return button.getAttribute("aria-disabled") !== "true";
}

/** Told to a screen reader, and shown for a moment. @param {string} text */
export function announce(text) {
  byId("status").textContent = text;
}

/** What went wrong, in the words of the server. @param {string | null} text */
export function trouble(text) {
  const place = byId("trouble");
  place.hidden = text === null;
  place.textContent = text ?? "";
}

/**
 * A call that waits until its caller has paused.
 * @template {any[]} A
 * @param {number} pause_ms
 * @param {(...args: A) => void} act
 * @returns {(...args: A) => void}
 */
export function afterPause(pause_ms, act) {
  /** @type {number | undefined} */
  let timer;
  return (...args) => {
    clearTimeout(timer);
    timer = setTimeout(() => act(...args), pause_ms);
  };
}

/**
 * A table with a heading row; cells are texts, numbers or elements.
 * @param {string} caption
 * @param {(string | { text: string, number?: boolean })[]} heads
 * @param {Child[][]} rows
 * @returns {HTMLElement}
 */
export function table(caption, heads, rows) {
  const columns = heads.map((h) => (typeof h === "string" ? { text: h, number: false } : h));
  return el(
    "div",
    { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    el(
      "table",
      {},
      el("caption", { class: "visually-hidden" }, caption),
      el(
        "thead",
        {},
        el(
          "tr",
          {},
          columns.map((c) => el("th", { scope: "col", class: c.number && "number" }, c.text)),
        ),
      ),
      el(
        "tbody",
        {},
        rows.map((cells) =>
          el(
            "tr",
            {},
            cells.map((cell, k) => el("td", { class: columns[k]?.number && "number" }, cell)),
          )
        ),
      ),
    ),
  );
}

/** A bar of a share between 0 and 1. @param {number} share */
export function bar(share) {
  const inner = el("i");
  inner.style.width = `${(100 * Math.max(0, Math.min(1, share))).toFixed(1)}%`;
  return inner;
}

/** Show a section with its entry in the contents, or neither. @param {string} id @param {boolean} there */
export function showSection(id, there) {
  byId(id).hidden = !there;
  const entry = document.querySelector(`.contents a[href="#${id}"]`)?.parentElement;
  if (entry) entry.hidden = !there;
}
