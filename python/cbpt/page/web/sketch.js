/**
 * A plot before the plotting library has been read: the same axes, lines and points, still.
 *
 * It knows what the first plot of the page needs: linear axes with their ranges given, one below
 * the other on the same x, lines, bands across, groups of points.
 */

/** @import { Built, Theme } from "./figure.js" */
import { svg } from "./dom.js";
import { plain } from "./numbers.js";
import { paths } from "./points.js";

/** @typedef {{ range?: [number, number], domain?: [number, number], title: { text: string } }} Axis */
/** @typedef {{ from: number, to: number, l2p: (v: number) => number }} Scale pixels of a value */

/** Room for a number on an axis, px, and how many there are at least and at most. */
const ROOM = { x: 80, y: 40, few: 5, many: 10 };
const TICK = 4;

/**
 * The plot, or null where its axes have no ends.
 * @param {Built} built dressed @param {number} width @param {Theme} t
 * @returns {SVGElement | null}
 */
export function sketch({ data, layout, points = [] }, width, t) {
  const { l, r, t: above, b } = layout.margin;
  const [wide, high] = [width - l - r, layout.height - above - b];
  if (!layout.xaxis.range || wide <= 0) return null;
  const x = scaleOf(layout.xaxis, wide, false);
  const panels = [];
  for (const [name, axis] of [["y", layout.yaxis], ["y2", layout.yaxis2]]) {
    if (!axis?.range) continue;
    const [low, top] = axis.domain;
    const y = scaleOf(axis, (top - low) * high, true);
    panels.push(svg(
      "g",
      { transform: `translate(${l} ${above + (1 - top) * high})` },
      layout.shapes.filter((/** @type {any} */ s) => s.yref === name).map((/** @type {any} */ s) =>
        svg("rect", {
          width: wide,
          y: y.l2p(s.y1),
          height: y.l2p(s.y0) - y.l2p(s.y1),
          fill: s.fillcolor,
          opacity: s.opacity,
        })
      ),
      ticksOf(y, (top - low) * high, ROOM.y).map((v) => [
        across(v === 0 ? t.line : t.faint, 0, wide, y.l2p(v)),
        across(t.line, -TICK, 0, y.l2p(v)),
        svg("text", { x: -TICK - 3, y: y.l2p(v) + 4, "text-anchor": "end" }, plain(v)),
      ]),
      ticksOf(x, wide, ROOM.x).map((v) =>
        svg("line", {
          x1: x.l2p(v),
          x2: x.l2p(v),
          y2: (top - low) * high,
          stroke: v === 0 ? t.line : t.faint,
        })
      ),
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
        transform: `translate(${14 - l} ${((top - low) * high) / 2}) rotate(-90)`,
        "text-anchor": "middle",
        fill: t.quiet,
      }, axis.title.text),
    ));
  }
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
      { transform: `translate(${l} ${above + high})` },
      ticksOf(x, wide, ROOM.x).map((v) => [
        svg("line", { x1: x.l2p(v), x2: x.l2p(v), y2: TICK, stroke: t.line }),
        svg("text", { x: x.l2p(v), y: TICK + 13, "text-anchor": "middle" }, plain(v)),
      ]),
      svg(
        "text",
        { x: wide / 2, y: b - 8, "text-anchor": "middle", fill: t.quiet },
        layout.xaxis.title.text,
      ),
    ),
  );
}

/** @param {string} stroke @param {number} x1 @param {number} x2 @param {number} y */
function across(stroke, x1, x2, y) {
  return svg("line", { x1, x2, y1: y, y2: y, stroke });
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

/** Round values along an axis. @param {Scale} scale @param {number} length @param {number} room */
function ticksOf({ from, to }, length, room) {
  const rough = (to - from) / Math.min(ROOM.many, Math.max(ROOM.few, length / room + 1));
  const ten = 10 ** Math.floor(Math.log10(rough));
  const step = ten * (/** @type {number} */ ([2, 5, 10].find((s) => s * ten >= rough)));
  const found = [];
  for (let k = Math.ceil(from / step); k * step <= to; k++) {
    found.push(Number((k * step).toPrecision(12)));
  }
  return found;
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
