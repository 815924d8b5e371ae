/**
 * 11. The drive: both pairs to scale, forces as arrows, meshing points by state, sliders, the curve.
 *
 * Lengths are mm as the document has them; the drawing's y points up, an SVG's down.
 */

/** @import { Theme } from "../lib/figure.js" */
/** @import { DrawnPair, DriveSection, Loop, Slider } from "../types.d.ts" */
import { isLive, post } from "../lib/api.js";
import { afterPause, bodyOf, byId, el, fill, svg, table, trouble } from "../lib/dom.js";
import { curveOf } from "./curve.js";
import { pairDrawing, sectionDrawing } from "../lib/drawing.js";
import { Figure, onTheme, saveDrawing, theme } from "../lib/figure.js";
import { fixed, plain, text } from "../lib/numbers.js";
import { decimals, documentShown, hasBalls, modelShown, on, scale, state } from "../lib/store.js";

/** @type {DriveSection | null} */
let shown = null;
/** @type {Record<string, number>} */
let load = {};
/** @type {Record<string, number>} */
let design = {};
let pairShown = 0;
/** Files whose drive is shown. @type {number | undefined} */
let of;
/** @type {Figure} */
let figure;
/** @type {HTMLElement} */
let whole;
/** @type {HTMLElement} */
let grooves;
/** @type {HTMLElement} */
let pictures;
/** @type {HTMLElement} */
let side;
/** @type {HTMLElement} */
let below;

export function setUpDrive() {
  pictures = el("div", { class: "card stack" });
  side = el("div", { class: "card stack" });
  const plot = el("div", { id: "drive-curve" });
  below = el("div", { class: "grid" });
  const curve = el(
    "div",
    { class: "card" },
    el("h3", {}, "Elastic angle over torque, without and with effects"),
    plot,
  );
  grooves = el("div", { class: "grid" }, pictures, below);
  whole = el(
    "div",
    { class: "grid two" },
    grooves,
    side,
  );
  fill(bodyOf("drive"), el("div", { class: "grid" }, whole, curve));
  figure = new Figure(plot, "drive_angle", "Elastic angle of the drive over torque", build, {
    height: 380,
    paper: 270,
  });
  figure.under(el("span", { class: "small quiet", id: "curve-note" }));
  on(["document"], () => {
    const { opened, drive } = documentShown();
    if (shown && of === opened) return;
    of = opened;
    asStated(drive);
    drawSliders();
    draw();
  });
  on(["unit"], draw);
  on(["model"], () => Object.keys(load).length ? ask() : figure.draw());
  onTheme(() => shown && drawPictures());
}

function draw() {
  figure.draw();
  drawPictures();
  drawFacts();
}

let asked = 0;

/** @param {DriveSection} drive */
function asStated(drive) {
  asked++;
  shown = drive;
  load = {};
  design = {};
}

const ask = afterPause(40, async () => {
  const mine = ++asked;
  try {
    const found = await post("drive", {
      load,
      design,
      // Before the diagnosis there is nothing fitted, and of a lack of fit there is no model.
      ...(modelShown().loop ? { effects: modelShown().effects } : {}),
    });
    if (mine !== asked) return;
    shown = found;
    trouble(null);
    draw();
  } catch (error) {
    if (mine === asked) trouble(error instanceof Error ? error.message : String(error));
  }
});

function drawSliders() {
  if (!shown?.sliders || !isLive()) {
    return fill(
      side,
      facts(),
      isLive() ? null : el(
        "p",
        { class: "small quiet no-print" },
        hasBalls()
          ? "In the workbench, sliders for load and design redraw all of this."
          : "In the workbench, sliders for the load redraw this.",
      ),
    );
  }
  const lists = shown.sliders;
  /** @param {Slider} s @param {Record<string, number>} into */
  const slider = (s, into) => {
    const written = el("output", {}, `${plain(s.value)} ${s.unit}`);
    return el(
      "label",
      { class: "slider" },
      el("span", {}, s.label),
      written,
      el("input", {
        type: "range",
        "aria-label": s.unit ? `${s.label}, ${s.unit}` : s.label,
        min: s.min,
        max: s.max,
        step: s.step,
        value: s.value,
        "data-key": s.key,
        oninput: (e) => {
          into[s.key] = Number(e.target.value);
          written.textContent = `${plain(into[s.key])} ${s.unit}`;
          ask();
        },
      }),
    );
  };
  fill(
    side,
    facts(),
    el("h3", {}, "Load"),
    el("div", { class: "sliders" }, lists.load.map((s) => slider(s, load))),
    lists.design.length > 0 && el(
      "details",
      {},
      el("summary", {}, "Design numbers"),
      el(
        "div",
        { class: "sliders" },
        lists.design.map((s) => slider(s, design)),
      ),
    ),
    el("button", {
      type: "button",
      onclick: () => (asStated(documentShown().drive), drawSliders(), draw()),
    }, "As in the case"),
  );
}

function facts() {
  return el("dl", { class: "facts", id: "drive-facts" });
}

function drawFacts() {
  const place = side.querySelector("#drive-facts");
  if (!(place instanceof HTMLElement) || !shown?.solution) return;
  const s = shown.solution, k = scale();
  /** @param {string} name @param {string} value @param {string} more */
  const fact = (name, value, more) =>
    el("div", {}, el("dt", {}, name), el("dd", {}, value, " ", el("small", {}, more)));
  const ofPairs = s.deceleration_arcsec !== null && hasBalls();
  const angle = (/** @type {number | null} */ v) => v === null ? "–" : fixed(v * k, decimals(2));
  fill(
    place,
    fact(
      "Elastic angle",
      angle(s.elastic_angle_arcsec),
      s.status === "ok" ? state.unit : s.message,
    ),
    ofPairs && fact("Part of the deceleration pair", angle(s.deceleration_arcsec), state.unit),
    ofPairs && fact("Part of the equal-speed pair", angle(s.equal_speed_arcsec), state.unit),
    fact("Stiffness", text(s.torsional_stiffness_Nm_per_arcsec, 3), "N m / arcsec"),
    fact(
      "Load",
      `${plain(shown.load.torque_Nm)} N m`,
      [
        shown.load.preload_N !== null && `${plain(shown.load.preload_N)} N preload`,
        hasBalls() && `input angle ${plain(shown.load.input_angle_deg)}°`,
      ].filter(Boolean).join(", "),
    ),
  );
  drawDesign();
}

/** Preload thresholds and findings of the design, where there are grooves. */
function drawDesign() {
  if (!shown || !hasBalls()) return fill(below);
  const t = shown.thresholds;
  const size = (/** @type {number | null} */ v) => (v === null ? "none does" : text(v, 4));
  fill(
    below,
    el(
      "div",
      { class: "card" },
      el(
        "h3",
        {},
        t
          ? `Preload (N) that a torque of ${
            plain(Math.abs(t.torque_Nm))
          } N m needs over a whole turn`
          : "Thresholds",
      ),
      t
        ? table(
          "Preload thresholds in N",
          [{ text: "part" }, { text: "to hold", number: true }, {
            text: "continuous",
            number: true,
          }, {
            text: "zero backlash",
            number: true,
          }],
          [
            { name: "drive", of: t.drive },
            { name: "deceleration pair", of: t.deceleration },
            { name: "equal-speed pair", of: t.equal_speed },
          ].map(({ name, of }) => [
            name,
            size(of.hold_N),
            size(of.continuous_N),
            size(of.zero_backlash_N),
          ]),
        )
        : el("p", { class: "quiet" }, "At zero torque there are no preload thresholds."),
      t && el(
        "p",
        { class: "small quiet" },
        "Thresholds hold at the worst input angle of a turn. The solution and the findings are for one input angle, which may need less preload.",
      ),
    ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Design findings"),
      shown.findings?.length
        ? el(
          "ul",
          { class: "plain" },
          shown.findings.map((f) =>
            el(
              "li",
              {},
              el("span", { class: `tag ${f.severity === "error" ? "rival" : ""}` }, f.severity),
              ` ${f.message}. `,
              el("span", { class: "quiet" }, f.remedy),
            )
          ),
        )
        : el(
          "p",
          { class: "quiet" },
          "No undercut, missing wall, touching balls or excessive pressure.",
        ),
    ),
  );
}

function drawPictures() {
  grooves.hidden = !hasBalls();
  whole.classList.toggle("two", hasBalls());
  if (!shown?.drawing) {
    return fill(
      pictures,
      el(
        "p",
        { class: "quiet" },
        documentShown().reasons.drive ?? shown?.why_no_drawing ?? "There is no drawing.",
      ),
    );
  }
  const pairs = shown.drawing.pairs;
  const t = theme();
  const names = pairs.map((p) => p.title);
  const pair = pairs[pairShown] ?? pairs[0];
  const drawing = pairDrawing(pair, t);
  const section = sectionDrawing(pair, t);
  fill(
    pictures,
    el(
      "div",
      { class: "row no-print", role: "group", "aria-label": "Pair shown" },
      pairs.map((_, k) =>
        el("button", {
          type: "button",
          class: "tab",
          "aria-pressed": String(k === pairShown),
          onclick: () => ((pairShown = k), drawPictures()),
        }, names[k])
      ),
    ),
    el("div", { class: "drawing", id: "drawing" }, drawing),
    el(
      "div",
      { class: "legend" },
      key(t.accent, "pressed by the torque", "dot"),
      key(t.quiet, "pressed, relieved by the torque", "dot"),
      key(t.warn, "parted", "ring"),
      el(
        "span",
        { class: "key" },
        `arrow: force on the output's plate${
          pair.arrow_mm_per_N ? `, longest ${text(longest(pair), 3)} N in plane` : ""
        }`,
      ),
    ),
    el(
      "div",
      { class: "grid halves cut" },
      el("div", { class: "drawing small-drawing" }, section),
      el(
        "dl",
        { class: "facts" },
        [[
          "Meshing points that carry",
          pair.carrying === null ? "–" : `${pair.carrying} of ${pair.points.length / 2}`,
        ], [
          "Largest contact pressure",
          pair.peak_pressure_GPa === null ? "–" : `${text(pair.peak_pressure_GPa, 3)} GPa`,
        ], [
          "Angle of this pair",
          pair.angle_arcsec === null
            ? "–"
            : `${fixed(pair.angle_arcsec * scale(), decimals(2))} ${state.unit}`,
        ]].map(([a, b]) => el("div", {}, el("dt", {}, a), el("dd", {}, b))),
      ),
    ),
    el(
      "div",
      { class: "no-print" },
      el("button", {
        type: "button",
        class: "text small",
        onclick: () => saveDrawing(drawing, pair.pair),
      }, "SVG of the pair"),
      el("button", {
        type: "button",
        class: "text small",
        onclick: () => saveDrawing(section, `${pair.pair}_section`),
      }, "SVG of the section"),
    ),
  );
}

/** @param {string} colour @param {string} name @param {string} kind */
function key(colour, name, kind) {
  return el(
    "span",
    { class: "key" },
    svg(
      "svg",
      { width: 12, height: 12, "aria-hidden": "true" },
      svg("circle", {
        cx: 6,
        cy: 6,
        r: 4,
        fill: kind === "dot" ? colour : "none",
        stroke: colour,
        "stroke-width": 1.6,
      }),
    ),
    name,
  );
}

/** @param {DrawnPair} pair */
function longest(pair) {
  return Math.max(0, ...pair.arrows.map((a) => a.force_N));
}

/** The loop of the model shown, where it is known at the load shown. @returns {Loop | null} */
function loopShown() {
  if (Object.keys(design).length) return null;
  return (Object.keys(load).length ? shown?.loop : modelShown().loop) ?? null;
}

/** @param {Theme} t */
function build(t) {
  if (!shown) return null;
  const loop = loopShown();
  const curve = curveOf(shown, loop, t);
  fill(
    byId("curve-note"),
    loop
      ? `Model shown: ${modelShown().label}, on its second cycle at this preload and input angle; the instruments of the rig are left out. `
      : Object.keys(design).length
      ? "Effects are fitted to the drive as it is in the case; they are not shown with other design numbers. "
      : documentShown().answer
      ? ""
      : "The curve with effects follows the diagnosis. ",
    curve.beyond,
  );
  return curve;
}
