// Formatting of numbers that is specific to the report.

import { formatCount, missing, withMinus } from '../../shared/format.js';

/// Fixed-point text; values that would round to zero are in scientific notation.
export function formatFixed(value, decimals) {
  if (value === null) return missing;
  const vanishes = value !== 0 && Math.abs(value) < 0.5 * 10 ** -decimals;
  return withMinus(vanishes ? value.toExponential(2) : value.toFixed(decimals));
}

/// Tick label of an axis, without trailing zeros and rounding errors.
export function formatTick(value) {
  return formatCount(Number(value.toPrecision(10)));
}

/// Smallest of 1, 2, 5 times a power of ten that is at least `value`, which is positive.
export function niceCeil(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  const step = [1, 2, 5, 10].find((m) => m * decade >= value * (1 - 1e-9)) ?? 10;
  return step * decade;
}
