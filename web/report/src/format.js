// Numbers as text. A true minus sign keeps signed columns readable.

const withMinus = (text) => text.replaceAll('-', '\u2212');
const missing = '\u2013';
const grouped = new Intl.NumberFormat('en-US', { maximumFractionDigits: 9 });

export function formatCount(value) {
  return value === null ? missing : withMinus(grouped.format(value));
}

/// Fixed decimals; what would round to zero is shown as a power of ten instead.
export function formatFixed(value, decimals) {
  if (value === null) return missing;
  const vanishes = value !== 0 && Math.abs(value) < 0.5 * 10 ** -decimals;
  return withMinus(vanishes ? value.toExponential(2) : value.toFixed(decimals));
}

/// A tick of an axis: no trailing zeros and no rounding noise.
export function formatTick(value) {
  return withMinus(grouped.format(Number(value.toPrecision(10))));
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `value`, which is positive.
export function niceCeil(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  const step = [1, 2, 5, 10].find((m) => m * decade >= value * (1 - 1e-9)) ?? 10;
  return step * decade;
}

/// The largest of 1, 2, 5 times a power of ten that is not above `value`, which is positive.
export function niceFloor(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  const step = [5, 2, 1].find((m) => m * decade <= value * (1 + 1e-9)) ?? 1;
  return step * decade;
}
