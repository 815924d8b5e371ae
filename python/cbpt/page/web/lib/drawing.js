/** The drive's pictures: a pair along its axis, and the ball that carries most cut across. */

/** @import { Theme } from "./figure.js" */
/** @import { DrawnPair, MeshingPoint } from "../types.d.ts" */
import { svg } from "./dom.js";
import { text } from "./numbers.js";

const STATES = /** @type {Record<string, string>} */ ({
  loaded: "carries",
  parted: "parted",
  wall_missing: "a wall is missing",
});
const ROLES = /** @type {Record<string, string>} */ ({
  FTMP: "the torque presses it",
  NFTMP: "the torque relieves it",
});

/** Colour of a meshing point. @param {MeshingPoint} point @param {Theme} t */
function colourOf(point, t) {
  if (point.state === null) return t.line;
  if (point.state !== "loaded") return t.warn;
  return point.role === "NFTMP" ? t.quiet : t.accent;
}

/** A pair along its axis. @param {DrawnPair} pair @param {Theme} t */
export function pairDrawing(pair, t) {
  const tips = pair.arrows.map((a) => Math.max(Math.abs(a.x + a.dx), Math.abs(a.y + a.dy)));
  const reach = 1.03 * Math.max(pair.extent_mm, ...tips);
  const width = reach / 330;
  const path = (/** @type {number[]} */ x, /** @type {number[]} */ y) =>
    x.map((v, k) => `${k ? "L" : "M"}${v} ${-y[k]}`).join("");
  const plate = (
    /** @type {string} */ p,
  ) => (p === pair.plates.output ? t.accent : p === "balls" ? t.line : t.warn);
  const look = (/** @type {{ plate: string, kind: string }} */ l) => ({
    fill: "none",
    stroke: plate(l.plate),
    "stroke-width": l.kind === "wall" ? 1.3 * width : 0.9 * width,
    "stroke-dasharray": l.kind === "wall" ? null : `${5 * width} ${3 * width}`,
    opacity: l.kind === "wall" ? 0.75 : 0.5,
  });
  const legend = (
    /** @type {string} */ name,
    /** @type {string} */ colour,
    /** @type {number} */ line,
  ) =>
    svg("text", {
      x: -reach + 6 * width,
      y: -reach + (20 + 20 * line) * width,
      "font-size": 14 * width,
      fill: colour,
    }, name);
  return svg(
    "svg",
    {
      viewBox: `${-reach} ${-reach} ${2 * reach} ${2 * reach}`,
      role: "img",
      "aria-label": `${pair.title}, to scale, with ${
        pair.carrying ?? "no"
      } meshing points that carry`,
      "font-family": "system-ui, sans-serif",
    },
    pair.lines.map((l) => svg("path", { d: path(l.x, l.y), ...look(l) })),
    pair.circles.map((c) => svg("circle", { cx: c.x, cy: -c.y, r: c.radius, ...look(c) })),
    pair.balls.map((b) =>
      svg("circle", {
        cx: b.x,
        cy: -b.y,
        r: b.radius,
        fill: t.faint,
        stroke: t.ink,
        "stroke-width": 1.1 * width,
      }, svg("title", {}, `ball ${b.number + 1}`))
    ),
    pair.points.map((p) => {
      const colour = colourOf(p, t);
      return svg(
        "circle",
        {
          cx: p.x,
          cy: -p.y,
          r: 3.6 * width,
          fill: p.state === "loaded" ? colour : t.card,
          stroke: colour,
          "stroke-width": 1.3 * width,
        },
        svg(
          "title",
          {},
          `ball ${p.ball + 1}, ${p.diagonal} diagonal, ${
            p.plate === "output" ? "output's" : "other"
          } plate: ${
            p.state === null
              ? "no solution"
              : `${STATES[p.state] ?? p.state}, ${text(p.force_N, 3)} N, ${
                ROLES[p.role ?? ""] ?? p.role
              }`
          }`,
        ),
      );
    }),
    pair.arrows.map((a) => arrow(a.x, -a.y, a.dx, -a.dy, width, t)),
    centres(pair, width, t),
    legend(
      pair.plates.output === "output" ? "output's plate" : `${pair.plates.output} (output)`,
      t.accent,
      0,
    ),
    legend(pair.plates.other, t.warn, 1),
    svg(
      "g",
      {},
      svg("path", {
        d: `M${reach - 20 * width - 10} ${reach - 14 * width}h10`,
        stroke: t.ink,
        "stroke-width": 2 * width,
      }),
      svg("text", {
        x: reach - 20 * width - 5,
        y: reach - 20 * width,
        "font-size": 12 * width,
        "text-anchor": "middle",
        fill: t.quiet,
      }, "10 mm"),
    ),
  );
}

/** Centres with their names apart, however close they lie. @param {DrawnPair} pair @param {number} width @param {Theme} t */
function centres(pair, width, t) {
  const sorted = [...pair.centres].sort((a, b) => a.x - b.x);
  return sorted.map((c, k) => {
    const [x, y, arm] = [c.x, -c.y, 5 * width];
    const below = (k % 2 ? -1 : 1) * (22 + 18 * (k >> 1)) * width;
    return svg(
      "g",
      {},
      svg("path", {
        d: `M${x - arm} ${y}h${2 * arm}M${x} ${y - arm}v${2 * arm}`,
        stroke: t.ink,
        "stroke-width": width,
      }),
      svg("path", {
        d: `M${x} ${y}V${y + 0.75 * below}`,
        stroke: t.line,
        "stroke-width": 0.7 * width,
      }),
      svg("text", {
        x,
        y: y + below + 4 * width,
        "font-size": 12 * width,
        "text-anchor": "middle",
        fill: t.quiet,
      }, c.label),
    );
  });
}

/** @param {number} x @param {number} y @param {number} dx @param {number} dy @param {number} width @param {Theme} t */
function arrow(x, y, dx, dy, width, t) {
  const length = Math.hypot(dx, dy);
  if (length < 2 * width) return null;
  const head = Math.min(8 * width, 0.6 * length);
  const [ux, uy] = [dx / length, dy / length];
  const [bx, by] = [x + dx - head * ux, y + dy - head * uy];
  return svg(
    "g",
    { stroke: t.ink, fill: t.ink },
    svg("path", { d: `M${x} ${y}L${bx} ${by}`, "stroke-width": 2 * width }),
    svg("path", {
      d: `M${x + dx} ${y + dy}L${bx - 0.38 * head * uy} ${by + 0.38 * head * ux}L${
        bx + 0.38 * head * uy
      } ${by - 0.38 * head * ux}Z`,
      "stroke-width": 0,
    }),
  );
}

/** The ball that carries most, cut across its grooves. @param {DrawnPair} pair @param {Theme} t */
export function sectionDrawing(pair, t) {
  const cut = pair.section;
  const r = cut.ball_radius_mm, reach = 2 * r, width = reach / 150;
  const most = Math.max(1e-9, ...cut.walls.map((w) => w.force_N ?? 0));
  return svg(
    "svg",
    {
      viewBox: `${-reach} ${-reach} ${2 * reach} ${2 * reach}`,
      role: "img",
      "aria-label": `Ball ${cut.ball + 1} cut across its grooves`,
      "font-family": "system-ui, sans-serif",
    },
    svg("circle", { cx: 0, cy: 0, r, fill: t.faint, stroke: t.ink, "stroke-width": width }),
    cut.walls.map((w) => {
      const colour = w.plate === "output" ? t.accent : t.warn;
      const size = 0.75 * r * ((w.force_N ?? 0) / most);
      return svg(
        "g",
        {},
        svg("path", {
          d: w.x.map((/** @type {number} */ v, /** @type {number} */ k) =>
            `${k ? "L" : "M"}${v} ${-w.y[k]}`
          ).join(""),
          fill: "none",
          stroke: colour,
          "stroke-width": 3 * width,
        }),
        arrow(w.contact.x, -w.contact.y, size * w.nx, -size * w.ny, 0.7 * width, t),
      );
    }),
    svg("text", {
      x: 0,
      y: 4 * width,
      "text-anchor": "middle",
      "font-size": 11 * width,
      fill: t.quiet,
    }, `ball ${cut.ball + 1}`),
    svg("text", {
      x: 0,
      y: -reach + 13 * width,
      "text-anchor": "middle",
      "font-size": 10 * width,
      fill: t.quiet,
    }, "output's plate"),
    svg("text", {
      x: 0,
      y: reach - 6 * width,
      "text-anchor": "middle",
      "font-size": 10 * width,
      fill: t.quiet,
    }, "other plate"),
  );
}
