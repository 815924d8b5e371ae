/**
 * Which effects the model has: switches change it, a report looks it up, the workbench fits it.
 */

/** @import { Choice } from "../types.d.ts" */
import { isLive, post } from "./api.js";
import { afterPause, announce, trouble } from "./dom.js";
import { pause, resume } from "./figure.js";
import { documentShown, modelOf, modelShown, on, setModel, size, state, tell } from "./store.js";

const PAUSE_MS = 250;
/** What the server was last asked for or told, so that it knows what may follow. */
let heard = "";

/** The server prepares what may be switched next, so it is told of models that it need not fit. */
export function setUpModels() {
  if (!isLive()) return;
  on(["document"], forget);
  on(["document"], () => heard = "");
  on(["model"], afterPause(PAUSE_MS, tellServer));
}

/** @type {number | undefined} */
let files;

/** Of other files nothing is on its way any more. */
function forget() {
  const { opened } = documentShown();
  if (files === opened) return;
  files = opened;
  latest++;
  wanted = null;
  resume();
}

function tellServer() {
  const { key, effects } = modelShown();
  if (key === heard || !documentShown().answer) return;
  heard = key;
  // It may have other files or be gone; nothing is lost.
  post("shown", { effects }).catch(() => {});
}

/** The key of the model with some effects. @param {string[]} effects */
export function keyOf(effects) {
  return [...effects].sort().join("+") || "stated";
}

/** Whether a switch of an effect can do anything. @param {string} effect */
export function canSwitch(effect) {
  return isLive() || modelOf(effect) !== undefined ||
    documentShown().models.some((m) => m.effects.includes(effect));
}

/** Whether an effect is in the model shown. @param {string} effect */
export function isOn(effect) {
  return modelShown().effects.includes(effect) ||
    (isRefitted(effect) && modelShown().key === "refitted");
}

/** Whether it is a number that the answer has refitted, which no effect stands for. @param {string} effect */
function isRefitted(effect) {
  return documentShown().candidates.some((c) => c.effect === effect && c.key === "refitted");
}

/** What a model is called that the search did not end at. */
export const ROUGH = "rough fit: the search did not converge";

let latest = 0;
/** The effects asked for last, while their model is on its way. @type {string[] | null} */
let wanted = null;

/** One effect on or off, of the model asked for last. @param {string} effect */
export function toggle(effect) {
  const now = wanted ?? modelShown().effects;
  if (isRefitted(effect) && !now.length) {
    setModel(isOn(effect) ? "stated" : "refitted");
    announce(told());
    return;
  }
  return show(now.includes(effect) ? now.filter((e) => e !== effect) : [...now, effect], effect);
}

/**
 * Show the model with some effects.
 * @param {string[]} effects
 * @param {string} [asked] the effect whose switch was used
 */
export async function show(effects, asked) {
  const mine = ++latest;
  const key = keyOf(effects);
  trouble(null);
  const there = modelOf(key) !== undefined;
  wanted = null;
  if (!there) {
    if (!isLive()) {
      const alone = asked && effects.includes(asked) ? asked : "stated";
      setModel(modelOf(alone) ? alone : "stated");
      announce(told());
      trouble(
        "This report holds no fit of these effects together. The workbench fits any combination.",
      );
      return;
    }
    try {
      heard = key;
      wanted = effects;
      pause();
      const formulas = definitions;
      const found = await post("model", { effects });
      // An own effect has been given another formula meanwhile.
      if (formulas !== definitions) return show(effects);
      take(found);
    } catch (error) {
      if (mine !== latest) return;
      wanted = null;
      resume();
      trouble(error instanceof Error ? error.message : String(error));
      tell("model");
      return;
    }
    // Another switch was used meanwhile; what has come is kept.
    if (mine !== latest) return tell("models");
    wanted = null;
  }
  resume();
  if (there) setModel(key);
  else setModel(key, "models");
  announce(told());
}

/**
 * Keep a model that the server has fitted, with its lines. Whoever shows it tells of it.
 * @param {Choice} found
 */
export function take(found) {
  const whole = documentShown();
  found.model.ladder = found.ladder;
  whole.models = [...whole.models.filter((m) => m.key !== found.model.key), found.model];
  whole.curves.forEach((line, k) => {
    line.angle_arcsec[found.model.key] = found.curves[k];
  });
}

let definitions = 0;

/** Let go of the models with an own effect that has another formula from now on. @param {string} effect */
export function redefined(effect) {
  definitions++;
  const whole = documentShown();
  whole.models = whole.models.filter((m) => !m.effects.includes(effect));
}

/** The model shown in one sentence. */
export function told() {
  const m = modelShown();
  return `Shown: ${m.label}; error ${size(m.rmse_arcsec)} ${state.unit}.${
    m.converged ? "" : ` It is a ${ROUGH}.`
  }`;
}
