/** What changed: a second table of the same reducer against the one shown. In the workbench alone. */

/** @import { ChangeSection, MeasuredLevel } from "../types.d.ts" */
/** @import { Theme } from "../lib/figure.js" */
import { compareWith, isLive, Superseded } from "../lib/api.js";
import { announce, bodyOf, byId, el, fill, showSection, table } from "../lib/dom.js";
import { Figure, safe, thin } from "../lib/figure.js";
import { probability, text, withUncertainty } from "../lib/numbers.js";
import { documentShown, inUnit, on, scale, state } from "../lib/store.js";

const MOST_DRAWN = 1500;
const WAYS = { up: "rose", down: "fell", new: "appeared", gone: "is no longer seen" };

/** @type {ChangeSection | null} */
let found = null;
/** Which files it is about. @type {number | undefined} */
let opened;
/** @type {Figure} */
let figure;

export function setUpChanged() {
  showSection("changed", isLive());
  if (!isLive()) return;
  const plot = el("div", { id: "changed-plot" });
  const chooser = el("input", {
    type: "file",
    id: "changed-file",
    class: "visually-hidden",
    onchange: (e) => take(e.target),
  });
  fill(
    bodyOf("changed"),
    el(
      "div",
      { class: "card stack" },
      el(
        "p",
        {},
        "Choose a second table of the same reducer: measured after a run-in, a turn of the preload " +
          "screws, a month of service. Its columns are read as those of the table shown, which is " +
          "the one before.",
      ),
      el("div", {}, el("label", { class: "button", for: "changed-file" }, "Table after"), chooser),
      el("div", { id: "changed-found", class: "stack", "aria-live": "polite" }),
      plot,
    ),
  );
  figure = new Figure(plot, "changed", "Angle against torque before and after", build, {
    height: 340,
    paper: 260,
  });
  figure.under(el("span", { class: "small quiet" }));
  plot.hidden = true;
  on(["document"], () => {
    if (opened === documentShown().opened) return; // a diagnosis of the same files
    opened = documentShown().opened;
    found = null;
    plot.hidden = true;
    fill(byId("changed-found"));
  });
  on(["unit"], show);
}

/** @param {HTMLInputElement} chooser */
async function take(chooser) {
  const file = chooser.files?.[0];
  chooser.value = "";
  if (!file) return;
  const place = byId("changed-found");
  const words = `Comparing ${file.name}: both tables are diagnosed, which may take a minute …`;
  fill(place, el("p", { class: "quiet" }, words));
  byId("changed-plot").hidden = true;
  try {
    found = await compareWith(file);
    show();
    announce(`${found.headline} ${found.rest}`);
  } catch (error) {
    if (error instanceof Superseded) return;
    const why = error instanceof Error ? error.message : String(error);
    fill(place, el("p", { class: "trouble", role: "alert" }, why));
  }
}

function show() {
  if (!found) return;
  const { changed, unchanged, levels, loops, notes } = found;
  const names = levels.map((l) => l.name);
  const angle = (/** @type {number} */ arcsec) => text(arcsec * scale());
  fill(
    byId("changed-found"),
    el("p", { id: "changed-sentence" }, el("strong", {}, found.headline)),
    found.rest && el("p", {}, found.rest),
    changed.length > 0 &&
      titled(
        "What changed",
        ["effect", "number", "before", "after", "", "probability"],
        changed.map((c) => [
          c.effect,
          c.number,
          c.before,
          c.after,
          WAYS[/** @type {keyof typeof WAYS} */ (c.direction)],
          probability(c.probability),
        ]),
      ),
    found.open.length > 0 &&
      titled(
        "What may have changed",
        ["effect", "probability", "why it is not told"],
        found.open.map((o) => [o.effect, probability(o.probability), o.why]),
      ),
    loops.length > 0 &&
      titled(
        `Width of the measured loops at zero torque (${state.unit})`,
        ["loops to (N m)", ...names],
        loops.map((w) => [
          text(w.amplitude_Nm),
          ...w.width_arcsec.map((width, k) => {
            const u = w.u_arcsec[k];
            return u === null ? angle(width) : withUncertainty(width * scale(), u * scale());
          }),
        ]),
      ),
    found.by_itself.length > 0 &&
      titled(
        "Each table fitted by itself",
        ["effect", "number", ...names],
        found.by_itself.map((b) => [b.effect, b.number, ...b.values]),
      ),
    unchanged.length > 0 &&
      titled(
        "What both share",
        ["effect", "number", "value"],
        unchanged.map((u) => [u.effect, u.number, u.value]),
      ),
    titled("The two tables", [
      "table",
      "readings",
      `error of the model (${state.unit})`,
      `scatter (${state.unit})`,
    ], levels.map((l) => [l.name, String(l.readings), angle(l.rmse_arcsec), angle(l.u_arcsec)])),
    notes.map((note) => el("p", { class: "small quiet" }, note)),
  );
  byId("changed-plot").hidden = false;
  figure.draw();
}

/** A table under its title. @param {string} title @param {string[]} heads @param {string[][]} rows */
function titled(title, heads, rows) {
  return el("div", {}, el("h3", {}, title), table(title, heads, rows));
}

/** @param {Theme} t */
function build(t) {
  if (!found) return null;
  const colours = t.levels(found.levels.length);
  return {
    data: found.levels.map((level, k) => dots(level, colours[k])),
    layout: {
      showlegend: true,
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 11 } },
      margin: { l: 58, r: 12, t: 10, b: 44 },
      xaxis: { title: "torque (N m)" },
      yaxis: { title: `elastic angle (${state.unit})` },
    },
  };
}

/** @param {MeasuredLevel} level @param {string} color */
function dots(level, color) {
  const torque = level.torque_Nm, angle = level.elastic_angle_arcsec;
  const rows = thin(torque.map((_, i) => i), torque, angle, MOST_DRAWN);
  return {
    type: "scatter",
    mode: "markers",
    name: safe(level.name),
    x: rows.map((i) => torque[i]),
    y: inUnit(rows.map((i) => angle[i])),
    marker: { size: 4, color, opacity: 0.8 },
    hovertemplate: `%{x} N m: %{y:.3f} ${state.unit}<extra></extra>`,
  };
}
