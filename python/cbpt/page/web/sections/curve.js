/** The drive's curve: the elastic angle over the torque, without effects and with those of a model. */

/** @import { Theme } from "../lib/figure.js" */
/** @import { DriveSection, Loop } from "../types.d.ts" */
import { reach, room, within } from "../lib/limits.js";
import { text } from "../lib/numbers.js";
import { hasBalls, inUnit, state } from "../lib/store.js";

/** An axis ends at this many times the size that half of the values stay below. */
const FAR = 6;

/**
 * Traces and layout; beyond: what the axes do not reach, in words.
 * @param {DriveSection} shown @param {Loop | null} loop @param {Theme} t
 */
export function curveOf(shown, loop, t) {
  const { angle_curve: c, solution, load: at } = shown;
  const line = (
    /** @type {string} */ name,
    /** @type {readonly (number | null)[]} */ y,
    /** @type {string} */ colour,
    /** @type {string} */ dash,
    /** @type {number} */ width,
    x = c.torque_Nm,
  ) => ({
    type: "scatter",
    mode: "lines",
    name,
    x,
    y: inUnit(y),
    line: { color: colour, dash, width },
    hovertemplate: `%{x:.3g} N m: %{y:.2f} ${state.unit}<extra>${name}</extra>`,
  });
  const legs = loop ? legsOf(loop) : [];
  const drawn = [
    ...legs.flatMap((leg, k) => bandOf(leg, t, k === 0)),
    ...(hasBalls()
      ? [
        line("deceleration pair alone", c.deceleration_arcsec, t.warn, "dash", 1.2),
        line("equal-speed pair alone", c.equal_speed_arcsec, t.quiet, "dot", 1.4),
      ]
      : []),
    line("drive as stated, without effects", c.elastic_angle_arcsec, t.ink, "solid", 1.3),
    ...legs.map((leg) => line(leg.name, leg.y, t.accent, leg.dash, 2.4, leg.x)),
    {
      type: "scatter",
      mode: "markers",
      name: "this load, without effects",
      x: [at.torque_Nm],
      y: inUnit([solution.elastic_angle_arcsec]),
      marker: { size: 9, color: t.ink },
      hovertemplate: `%{x:.3g} N m: %{y:.2f} ${state.unit}<extra>this load</extra>`,
    },
  ].filter((l) => l.y.some((v) => v !== null));
  const values = drawn.flatMap((l) => l.y);
  const whole = [...c.elastic_angle_arcsec, ...(loop?.elastic_angle_arcsec ?? [])];
  const most = reach(inUnit(whole), 0.5, FAR);
  const far = reach(values, 1, 1);
  return {
    beyond: far > most
      ? `The axis ends at ${text(most, 2)} ${state.unit}; angles near the holding limit go to ${
        text(far, 3)
      } ${state.unit}.`
      : "",
    data: drawn,
    layout: {
      showlegend: true,
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 11 } },
      margin: { l: 58, r: 12, t: 10, b: 44 },
      xaxis: { title: "torque (N m)" },
      yaxis: { title: `elastic angle (${state.unit})`, range: room(within(values, [-most, most])) },
    },
  };
}

/** @typedef {{ name: string, dash: string, x: number[], y: (number | null)[], u: (number | null)[] | null }} Leg */

/** Both ways of the torque; one line where they are the same. @param {Loop} loop @returns {Leg[]} */
function legsOf({ torque_Nm, elastic_angle_arcsec: angle, u_arcsec }) {
  const half = (torque_Nm.length - 1) / 2;
  /** @param {string} way @param {string} dash @param {number} first @param {number} last @returns {Leg} */
  const leg = (way, dash, first, last) => ({
    name: `with the model's effects${way}`,
    dash,
    x: torque_Nm.slice(first, last),
    y: angle.slice(first, last),
    u: u_arcsec?.slice(first, last) ?? null,
  });
  const size = reach(angle, 0.5, FAR);
  const back = angle.slice(half).reverse();
  const alike = back.every((v, k) => Math.abs((v ?? 0) - (angle[k] ?? 0)) <= 1e-4 * size);
  if (alike) return [leg("", "solid", half, torque_Nm.length)];
  return [
    leg(", torque rising", "solid", half, torque_Nm.length),
    leg(", torque falling", "5px,3px", 0, half + 1),
  ];
}

/** What the model's own uncertainty leaves open. @param {Leg} leg @param {Theme} t @param {boolean} first */
function bandOf({ x, y, u }, t, first) {
  const there = y.flatMap((v, k) => v !== null && u?.[k] ? [k] : []);
  if (!u || !there.length) return [];
  const back = [...there].reverse();
  const side = (/** @type {number} */ k, /** @type {number} */ way) =>
    (y[k] ?? 0) + way * (u[k] ?? 0);
  return [{
    type: "scatter",
    mode: "lines",
    name: "± 2 standard uncertainties of the model",
    legendgroup: "band",
    showlegend: first,
    x: [...there, ...back].map((k) => x[k]),
    y: inUnit([...there.map((k) => side(k, 2)), ...back.map((k) => side(k, -2))]),
    fill: "toself",
    fillcolor: `${t.accent}33`,
    line: { width: 0, color: t.accent },
    hoverinfo: "skip",
  }];
}
