// Numbers as text, where the report needs them otherwise than other pages.

import { formatCount, missing, withMinus } from '../../shared/format.js';

/// Fixed decimals; what would round to zero is shown as a power of ten instead.
export function formatFixed(value, decimals) {
  if (value === null) return missing;
  const vanishes = value !== 0 && Math.abs(value) < 0.5 * 10 ** -decimals;
  return withMinus(vanishes ? value.toExponential(2) : value.toFixed(decimals));
}

/// A tick of an axis: no trailing zeros and no rounding noise.
export function formatTick(value) {
  return formatCount(Number(value.toPrecision(10)));
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `value`, which is positive.
export function niceCeil(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  const step = [1, 2, 5, 10].find((m) => m * decade >= value * (1 - 1e-9)) ?? 10;
  return step * decade;
}
