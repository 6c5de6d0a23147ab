// Formatting of numbers. A true minus sign keeps signed columns readable.

const grouped = new Intl.NumberFormat('en-US', { maximumFractionDigits: 9 });

export const withMinus = (text) => text.replaceAll('-', '\u2212');
export const missing = '\u2013';
export const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

export function formatCount(value) {
  return isNumber(value) ? withMinus(grouped.format(value)) : missing;
}

/// Largest of 1, 2, 5 times a power of ten that is at most `value`, which is positive.
export function niceFloor(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  const step = [5, 2, 1].find((m) => m * decade <= value * (1 + 1e-9)) ?? 1;
  return step * decade;
}
