/**
 * How numbers are written: digits that can be seen, uncertainty beside. The texts of the answer
 * round in the same way (`lab/wording/numbers.py`), so a number has the same digits everywhere.
 */

/**
 * A number with so many significant digits at most; a minus sign that is one.
 * @param {number | null | undefined} value
 * @param {number} [digits]
 * @returns {string}
 */
export function text(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const rounded = Number(value.toPrecision(digits));
  const size = Math.abs(rounded);
  const shown = size > 0 && (size >= 1e6 || size < 1e-4)
    ? rounded.toExponential().replace("e+", "e")
    : String(rounded);
  return shown.replace("-", "−").replace("e-", "e−");
}

/**
 * A value and its uncertainty, both to the place of two digits of the uncertainty.
 * @param {number} value
 * @param {number} u
 */
export function withUncertainty(value, u) {
  if (!(u > 0) || !Number.isFinite(u)) return text(value);
  const last = Number(u.toPrecision(2));
  const place = Math.floor(Math.log10(last) + 1e-9) - 1;
  if (place < -5) return `${text(value)} ± ${text(u, 2)}`;
  if (place > 0) {
    const size = 10 ** place;
    return `${fixed(Math.round(value / size) * size, 0)} ± ${fixed(last, 0)}`;
  }
  return `${fixed(value, -place)} ± ${fixed(u, -place)}`;
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
