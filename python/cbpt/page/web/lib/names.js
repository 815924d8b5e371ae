/** Keys of the document as people read them. */

import { documentShown } from "./store.js";

/**
 * A quantity's name from its key: `torque_Nm` is "torque (N m)".
 * @param {string} key
 */
export function nameOf(key) {
  const units = documentShown().units_of_keys;
  const words = key.split("_");
  // The first that fits is the longest: N m/rad is no 1/rad.
  for (let k = 1; k < words.length; k++) {
    const unit = words[k - 1] === "per" ? undefined : units[words.slice(k).join("_")];
    if (unit) return `${words.slice(0, k).join(" ")} (${unit})`;
  }
  return words.join(" ");
}

/** With a capital and a full stop. @param {string} words */
export function asSentence(words) {
  return `${withCapital(words)}${words.endsWith(".") ? "" : "."}`;
}

/** @param {string} words */
export function withCapital(words) {
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** As printed: ±, a minus sign. @param {string} words */
export function inPrint(words) {
  return words.replaceAll("+-", "±").replace(/(^|[\s(])-(?=\d)/g, "$1−");
}
