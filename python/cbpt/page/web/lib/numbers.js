/** How numbers are written: digits that can be seen, uncertainty beside. */

/**
 * A number with some significant digits; a minus sign that is one.
 * @param {number | null | undefined} value
 * @param {number} [digits]
 * @returns {string}
 */
export function text(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const shown = size >= 1e5 || size < 1e-3
    ? value.toExponential(digits - 1).replace("e+", "e")
    : size >= 10 ** digits
    ? value.toFixed(0)
    : value.toPrecision(digits);
  return shown.replace("-", "−").replace("e-", "e−");
}

/**
 * A number that was stated or set: no more digits than it has.
 * @param {number | null | undefined} value
 * @param {number} [digits]
 */
export function plain(value, digits = 5) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(digits))).replace("-", "−").replace("e-", "e−");
}

/**
 * A number with a fixed count of decimals.
 * @param {number | null | undefined} value
 * @param {number} decimals
 * @param {boolean} [signed]
 */
export function fixed(value, decimals, signed = false) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const shown = value.toFixed(decimals).replace("-", "−");
  return signed && value > 0 ? `+${shown}` : shown;
}

/** A probability, never more certain than it can be. @param {number | null | undefined} p */
export function probability(p) {
  if (p === null || p === undefined) return "–";
  if (p < 0.005) return "< 0.01";
  return p > 0.995 ? "> 0.99" : p.toFixed(2);
}

/** A share in percent. @param {number} share */
export function percent(share) {
  return `${(100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`;
}

/** @param {readonly (number | null)[]} values */
export function rms(values) {
  let sum = 0, count = 0;
  for (const v of values) {
    if (v === null) continue;
    sum += v * v;
    count += 1;
  }
  return count ? Math.sqrt(sum / count) : NaN;
}
