/** The bar that stays in sight: a switch for each likely effect, and what is left of the error. */

import { byId, el, fill, setUsable, svg, usable } from "../lib/dom.js";
import { onTheme, theme } from "../lib/figure.js";
import { canSwitch, isOn, ROUGH, setUpModels, show, toggle } from "../lib/models.js";
import { documentShown, modelOf, modelShown, on, size, state } from "../lib/store.js";

/** As many as stand beside the gauge in one line. */
function mostSwitches() {
  return innerWidth > 1500 ? 5 : 3;
}

export function setUpBar() {
  setUpModels();
  on(["document"], draw);
  on(["models", "model", "unit"], follow);
  onTheme(() => state.document && follow());
}

/** @type {string[]} effects whose switches stand in the bar */
let there = [];

function draw() {
  const bar = byId("model-bar");
  bar.hidden = false;
  there = offered();
  fill(
    bar,
    el(
      "div",
      { class: "switches", role: "group", "aria-label": "Effects in the model" },
      there.map(switchOf),
    ),
    documentShown().models.length > 1 && el(
      "button",
      {
        type: "button",
        class: "text small",
        id: "as-stated",
        onclick: (e) => usable(e.currentTarget) && show([]),
        "aria-disabled": String(state.model === "stated"),
      },
      "as stated",
    ),
    gauge(),
  );
}

/** Only what changes: to lay the bar out anew takes as long as all the rest. */
function follow() {
  const all = byId("model-bar").querySelector("#as-stated");
  if (!all || offered().join() !== there.join()) return draw();
  setUsable(all, state.model !== "stated");
  markSwitches(byId("model-bar"));
  byId("gauge").replaceWith(gauge());
}

/** The effects of the answer and of what is shown, then the likeliest. */
function offered() {
  const whole = documentShown();
  const known = whole.candidates.filter((c) => canSwitch(c.effect));
  const first = [
    ...(whole.answer?.verdict.effects ?? []),
    ...modelShown().effects,
    ...known.filter((c) => c.in_answer || c.is_rival).map((c) => c.effect),
  ];
  const rest = known.map((c) => c.effect);
  const own = whole.models.filter((m) => m.role === "own").flatMap((m) => m.effects);
  const all = [...new Set([...first, ...own, ...rest])].filter(canSwitch);
  return all.slice(0, Math.max(mostSwitches(), modelShown().effects.length));
}

/** @param {string} effect */
export function switchOf(effect) {
  return el(
    "button",
    {
      type: "button",
      class: "switch",
      role: "switch",
      "aria-checked": String(isOn(effect)),
      "data-effect": effect,
      title: documentShown().candidates.find((c) => c.effect === effect)?.label ?? effect,
      onclick: () => toggle(effect),
    },
    effect.replaceAll("_", " "),
  );
}

/** Switches follow the model shown. @param {Element} place */
export function markSwitches(place) {
  for (const button of place.querySelectorAll(".switch")) {
    const { effect } = /** @type {HTMLElement} */ (button).dataset;
    button.setAttribute("aria-checked", String(isOn(effect ?? "")));
  }
}

/** The error of the model shown on a scale from nothing to the error as stated, the noise marked. */
function gauge() {
  const whole = documentShown();
  const m = modelShown();
  const before = modelOf("stated")?.rmse_arcsec ?? null;
  const now = m.rmse_arcsec;
  const floor = whole.noise?.noise_floor_arcsec ?? null;
  const most = Math.max(before ?? 0, now ?? 0, 1e-9);
  const width = 110;
  const t = theme();
  const x = (/** @type {number} */ v) => 1 + (width - 2) * Math.min(1, v / most);
  const picture = svg(
    "svg",
    { width, height: 22, viewBox: `0 0 ${width} 22`, "aria-hidden": "true" },
    svg("rect", { x: 1, y: 8, width: width - 2, height: 6, rx: 3, fill: t.faint }),
    now !== null &&
      svg("rect", { x: 1, y: 8, width: x(now) - 1, height: 6, rx: 3, fill: t.accent }),
    floor !== null &&
      svg("line", { x1: x(floor), x2: x(floor), y1: 3, y2: 19, stroke: t.warn, "stroke-width": 2 }),
  );
  return el(
    "div",
    { class: "gauge", id: "gauge" },
    picture,
    el("span", {}, el("b", { id: "rmse" }, size(now)), ` ${state.unit}`),
    el(
      "span",
      { class: "small quiet" },
      m.held_out_rmse_arcsec !== null &&
        el("span", {}, `held out ${size(m.held_out_rmse_arcsec)}`),
      !m.converged && el("span", { title: ROUGH }, "rough fit"),
      whole.noise && el(
        "span",
        { title: `noise: ${whole.noise.noise_floor_of}` },
        floor === null ? "noise not known" : `noise ${size(floor)}`,
      ),
    ),
  );
}
