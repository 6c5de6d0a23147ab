// Numbers as text. A true minus sign keeps signed columns readable.

const withMinus = (text) => text.replaceAll('-', '\u2212');
const missing = '\u2013';
const grouped = new Intl.NumberFormat('en-US', { maximumFractionDigits: 9 });

export const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

export function formatCount(value) {
  return isNumber(value) ? withMinus(grouped.format(value)) : missing;
}

export function formatFixed(value, decimals) {
  return isNumber(value) ? withMinus(value.toFixed(decimals)) : missing;
}

/// A number for a field: as short as it can be without showing rounding noise.
export function formatField(value) {
  return String(Number(value.toPrecision(6)));
}

/// A length as people say it: 2 m, 5 cm, 0.4 mm.
export function formatLength(metres) {
  const [unit, size] = metres >= 1 ? ['m', 1] : metres >= 0.01 ? ['cm', 0.01] : ['mm', 0.001];
  return `${grouped.format(Number((metres / size).toPrecision(2)))} ${unit}`;
}

/// The largest of 1, 2, 5 times a power of ten that is not above `value`, which is positive.
export function niceFloor(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  const step = [5, 2, 1].find((m) => m * decade <= value * (1 + 1e-9)) ?? 1;
  return step * decade;
}
