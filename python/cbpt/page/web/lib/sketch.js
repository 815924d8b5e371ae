/**
 * A plot before the plotting library has been read: the same axes, lines and points, still.
 *
 * It knows what the first plot of the page needs: linear axes with their ranges given, one below
 * the other on the same x, lines, bands across, groups of points.
 */

/** @import { Built, Theme } from "./figure.js" */
import { svg } from "./dom.js";
import { paths } from "./points.js";

/** @typedef {{ range?: [number, number], domain?: [number, number], title: { text: string } }} Axis */
/** @typedef {{ from: number, to: number, l2p: (v: number) => number }} Scale pixels of a value */

/** @typedef {{ at: number, text: string, power: string }} Tick power: of ten that the text is times */

/** Room for a number on an axis, px, and how many there are at least and at most. */
const ROOM = { x: 80, y: 40, few: 5, many: 10 };
/** Where an axis has its line, its ticks and its numbers, px outwards. */
const LINE = 0.5;
const TICK = { from: 1, to: 5 };
const NUMBER = { left: 7.4, below: 19.4 };
/** From numbers to the foot of the title at their left, and the room that it takes, px. */
const TITLE = { foot: 9.7, room: 25 };
/** Numbers of an axis that reaches further than this power of ten, or not so far, are times a power. */
export const MOST_PLAIN_POWER = 5;

/**
 * The plot, or null where its axes have no ends.
 * @param {Built} built dressed @param {number} width @param {Theme} t
 * @returns {SVGElement | null}
 */
export function sketch({ data, layout, points = [] }, width, t) {
  const { l, r, t: above } = layout.margin;
  const wide = width - l - r;
  if (!layout.xaxis.range || wide <= 0) return null;
  const x = scaleOf(layout.xaxis, wide, false);
  const across = ticksOf(layout.xaxis, wide, ROOM.x);
  const all = panelsOf(layout);
  const foot = Math.max(...all.map((p) => p.top + p.high));
  const panels = all.map(({ name, axis, top, high, ticks }) => {
    const y = scaleOf(axis, high, true);
    return svg(
      "g",
      { transform: `translate(${l} ${above + top})` },
      layout.shapes.filter((/** @type {any} */ s) => s.yref === name).map((/** @type {any} */ s) =>
        svg("rect", {
          width: wide,
          y: y.l2p(s.y1),
          height: y.l2p(s.y0) - y.l2p(s.y1),
          fill: s.fillcolor,
          opacity: s.opacity,
        })
      ),
      ticks.map((v) => [
        line(v.at === 0 ? t.line : t.faint, [0, y.l2p(v.at)], [wide, y.l2p(v.at)]),
        line(t.line, [-TICK.to, y.l2p(v.at)], [-TICK.from, y.l2p(v.at)]),
        number(v, { x: -NUMBER.left, y: y.l2p(v.at) + 4.2, "text-anchor": "end" }),
      ]),
      across.map((v) => line(v.at === 0 ? t.line : t.faint, [x.l2p(v.at), 0], [x.l2p(v.at), high])),
      line(t.line, [-LINE, 0], [-LINE, high]),
      data.filter((d) => d.line && (d.yaxis ?? "y") === name && d.hoverinfo === "skip").map((d) =>
        svg("path", {
          d: lineOf(d, x, y),
          fill: "none",
          stroke: d.line.color,
          "stroke-width": d.line.width,
          "stroke-dasharray": /px/.test(d.line.dash) ? d.line.dash.replaceAll("px", "") : null,
        })
      ),
      points.filter((g) => g.axis === name).map((g) => paths(g, x, y)),
      svg("text", {
        transform: `translate(${-NUMBER.left - widest(ticks, layout.font) - TITLE.foot} ${
          high / 2
        }) rotate(-90)`,
        "text-anchor": "middle",
        fill: t.quiet,
      }, axis.title.text),
    );
  });
  return svg(
    "svg",
    {
      width,
      height: layout.height,
      "aria-hidden": "true",
      "font-family": layout.font.family,
      "font-size": layout.font.size,
      fill: t.ink,
    },
    panels,
    svg(
      "g",
      { transform: `translate(${l} ${above + foot})` },
      line(t.line, [-TICK.from, LINE], [wide, LINE]),
      across.map((v) => [
        line(t.line, [x.l2p(v.at), TICK.from], [x.l2p(v.at), TICK.to]),
        number(v, { x: x.l2p(v.at), y: NUMBER.below, "text-anchor": "middle" }),
      ]),
      svg(
        "text",
        { x: wide / 2, y: NUMBER.below + 17, "text-anchor": "middle", fill: t.quiet },
        layout.xaxis.title.text,
      ),
    ),
  );
}

/** What the numbers and titles at the left of the panels need, px. @param {any} layout */
export function leftMargin(layout) {
  const each = panelsOf(layout).map(({ ticks }) => widest(ticks, layout.font));
  return Math.ceil(NUMBER.left + Math.max(0, ...each) + TITLE.room);
}

/** The plots one below the other, with the numbers at their left; top and height in px. @param {any} layout */
function panelsOf(layout) {
  const whole = layout.height - layout.margin.t - layout.margin.b;
  return [["y", layout.yaxis], ["y2", layout.yaxis2]].filter(([_, axis]) => axis?.range).map((
    [name, axis],
  ) => {
    const [low, top] = axis.domain;
    const high = (top - low) * whole;
    return { name, axis, top: (1 - top) * whole, high, ticks: ticksOf(axis, high, ROOM.y) };
  });
}

/** @param {string} stroke @param {[number, number]} from @param {[number, number]} to */
function line(stroke, [x1, y1], [x2, y2]) {
  return svg("line", { x1, y1, x2, y2, stroke, "shape-rendering": "crispEdges" });
}

/** @param {Tick} tick @param {Record<string, string | number>} place */
function number({ text, power }, place) {
  return svg(
    "text",
    place,
    text,
    power !== "" && svg("tspan", { "font-size": "70%", dy: "-0.6em" }, power),
  );
}

/** @type {CanvasRenderingContext2D | null | undefined} */
let ruler;

/** The width of the longest number, px. @param {Tick[]} ticks @param {{ family: string, size: number }} font */
function widest(ticks, font) {
  ruler ??= document.createElement("canvas").getContext("2d");
  if (!ruler) return 0;
  ruler.font = `${font.size}px ${font.family}`;
  let most = 0;
  for (const { text, power } of ticks) {
    most = Math.max(most, ruler.measureText(text).width + 0.7 * ruler.measureText(power).width);
  }
  return most;
}

/** @param {Axis} axis @param {number} length px @param {boolean} up @returns {Scale} */
function scaleOf(axis, length, up) {
  const [from, to] = /** @type {[number, number]} */ (axis.range);
  const l2p = (/** @type {number} */ v) => {
    const share = (v - from) / (to - from || 1);
    return length * (up ? 1 - share : share);
  };
  return { from, to, l2p };
}

/**
 * Round values along an axis and their numbers, both as Plotly has them.
 * @param {Axis} axis @param {number} length px @param {number} room
 * @returns {Tick[]}
 */
function ticksOf(axis, length, room) {
  const [from, to] = /** @type {[number, number]} */ (axis.range);
  const rough = (to - from) / Math.min(ROOM.many, Math.max(ROOM.few, length / room + 1));
  const ten = 10 ** Math.floor(Math.log10(rough));
  const step = ten * (/** @type {number} */ ([2, 5, 10].find((s) => s * ten >= rough)));
  const reach = powerOf(Math.max(Math.abs(from), Math.abs(to)));
  const power = Math.abs(reach) > MOST_PLAIN_POWER ? reach : 0;
  const decimals = Math.min(20, Math.max(0, power + 2 - powerOf(step)));
  const found = [];
  for (let k = Math.ceil(from / step); k * step <= to; k++) {
    const times = power !== 0 && k !== 0;
    const digits = (Math.abs(k * step) / 10 ** power).toFixed(decimals).replace(
      /\.0+$|(\.\d*[1-9])0+$/,
      "$1",
    );
    found.push({
      at: Number((k * step).toPrecision(12)),
      text: `${k < 0 ? "−" : ""}${digits}${times ? "×10" : ""}`,
      power: times ? String(power).replace("-", "−") : "",
    });
  }
  return found;
}

/** The power of ten that a size begins with. @param {number} size */
function powerOf(size) {
  return Math.floor(Math.log10(size) + 0.01);
}

/** @param {{ x: number[], y: (number | null)[] }} line @param {Scale} x @param {Scale} y */
function lineOf(line, x, y) {
  let d = "", pen = "M";
  line.x.forEach((v, k) => {
    const w = line.y[k];
    if (w === null || !Number.isFinite(w)) pen = "M";
    else {
      d += `${pen}${x.l2p(v).toFixed(1)} ${y.l2p(w).toFixed(1)}`;
      pen = "L";
    }
  });
  return d;
}
