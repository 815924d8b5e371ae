/**
 * Many points in a plot, one path for each group: Plotly makes an element a point, which a switch
 * of an effect would wait for. In files the same points are Plotly's own.
 */

import { svg } from "./dom.js";

/**
 * @typedef {"up" | "down" | "dot" | "small"} Sign
 * @typedef {{ axis: "y" | "y2", x: readonly number[], y: readonly (number | null)[],
 *   u?: readonly (number | null)[] | null, sign: Sign, colour: string, opacity?: number }} Points
 *   u: half length of the bars
 */

/** Plotly's names of the signs, with their sizes. */
const SYMBOLS = {
  up: { symbol: "triangle-up", size: 7 },
  down: { symbol: "triangle-down-open", size: 7 },
  dot: { symbol: "circle", size: 5.5 },
  small: { symbol: "circle", size: 3 },
};

/** @type {Record<Sign, string>} what is drawn from a point on, in pixels */
const STROKES = {
  up: "m0-4.4 4 7.2h-8z",
  down: "m0 4.4 4-7.2h-8z",
  dot: "m0 0h0",
  small: "m0 0h0",
};

/** The groups as traces, for files. @param {Points[]} groups @returns {any[]} */
export function asTraces(groups) {
  return groups.flatMap((g) => {
    const common = { type: "scatter", yaxis: g.axis, opacity: g.opacity ?? 1, hoverinfo: "skip" };
    const { symbol, size } = SYMBOLS[g.sign];
    const points = { ...common, mode: "markers", x: g.x, y: g.y };
    const bars = ends(g);
    return [
      bars.length > 0 && {
        ...common,
        mode: "lines",
        opacity: 0.45 * common.opacity,
        line: { color: g.colour, width: 1 },
        x: bars.flatMap(([x]) => [x, x, null]),
        y: bars.flatMap(([, low, high]) => [low, high, null]),
      },
      {
        ...points,
        marker: {
          symbol,
          size,
          color: g.colour,
          line: { width: g.sign === "down" ? 1.3 : 0, color: g.colour },
        },
      },
    ].filter(Boolean);
  });
}

/** Where bars begin and end. @param {Points} g @returns {[number, number, number][]} */
function ends(g) {
  /** @type {[number, number, number][]} */
  const found = [];
  g.x.forEach((x, k) => {
    const [y, u] = [g.y[k], g.u?.[k] ?? null];
    if (y !== null && u !== null) found.push([x, y - u, y + u]);
  });
  return found;
}

/**
 * Lay the groups over a plot that Plotly has drawn.
 * @param {HTMLElement} area @param {Points[]} groups
 */
export function layOver(area, groups) {
  const full = /** @type {any} */ (area)._fullLayout;
  for (const axis of /** @type {const} */ (["y", "y2"])) {
    const plot = full?._plots?.[`x${axis}`]?.plot?.node();
    if (!plot) continue;
    plot.querySelector("g.readings")?.remove();
    const across = full.xaxis, up = full[axis === "y" ? "yaxis" : "yaxis2"];
    plot.append(
      svg(
        "g",
        { class: "readings", "pointer-events": "none" },
        groups.filter((g) => g.axis === axis).map((g) => paths(g, across, up)),
      ),
    );
  }
}

/**
 * @typedef {{ l2p: (value: number) => number }} Along an axis, Plotly's or a sketch's: pixels of a value
 * @param {Points} g @param {Along} across @param {Along} up
 */
export function paths(g, across, up) {
  let d = "";
  const px = (/** @type {number} */ v) => across.l2p(v).toFixed(1);
  const py = (/** @type {number} */ v) => up.l2p(v).toFixed(1);
  const stroke = STROKES[g.sign];
  g.x.forEach((x, k) => {
    const y = g.y[k];
    if (y !== null) d += `M${px(x)} ${py(y)}${stroke}`;
  });
  const bars = ends(g).map(([x, low, high]) => `M${px(x)} ${py(low)}V${py(high)}`).join("");
  const dot = g.sign === "dot" || g.sign === "small";
  return svg(
    "g",
    { class: "signs", stroke: g.colour, opacity: g.opacity ?? 1 },
    bars !== "" && svg("path", { d: bars, "stroke-width": 1, opacity: 0.45 }),
    svg("path", {
      d,
      fill: g.sign === "up" ? g.colour : "none",
      "stroke-width": dot ? SYMBOLS[g.sign].size : g.sign === "down" ? 1.3 : 0,
      "stroke-linecap": dot ? "round" : null,
    }),
  );
}
