/**
 * How far axes reach. Near the holding limit an angle grows a hundredfold, and an axis that held it
 * would flatten all that there is to see; what lies beyond the end of an axis is told below the plot.
 */

/**
 * The largest size of the values, but at most `times` the size that a share of them stays below.
 * @param {readonly (number | null)[]} values @param {number} share @param {number} times
 */
export function reach(values, share, times) {
  const sizes = values.flatMap((v) => v === null || !isFinite(v) ? [] : [Math.abs(v)])
    .sort((a, b) => a - b);
  if (!sizes.length) return 0;
  const most = sizes[sizes.length - 1];
  const usual = sizes[Math.floor(share * (sizes.length - 1))];
  return usual > 0 ? Math.min(most, times * usual) : most;
}

/**
 * Both ends with some room, or nothing where there is no value.
 * @param {readonly (number | null)[]} values
 * @returns {[number, number] | undefined}
 */
export function room(values) {
  let low = Infinity, high = -Infinity;
  for (const v of values) {
    if (v === null || !isFinite(v)) continue;
    low = Math.min(low, v);
    high = Math.max(high, v);
  }
  if (low > high) return undefined;
  const more = 0.05 * (high - low) || 1;
  return [low - more, high + more];
}

/** Values within two ends. @param {readonly (number | null)[]} values @param {readonly number[]} ends */
export function within(values, [low, high]) {
  return values.map((v) => v === null || !isFinite(v) ? null : Math.min(Math.max(v, low), high));
}
