// Formatting of numbers that is specific to the viewer.

import { formatCount, isNumber, missing, withMinus } from '../../shared/format.js';

export function formatFixed(value, decimals) {
  return isNumber(value) ? withMinus(value.toFixed(decimals)) : missing;
}

/// Text of a number for a field, without rounding errors.
export function formatField(value) {
  return String(Number(value.toPrecision(6)));
}

/// Size of a file: 5.7 MB.
export function formatBytes(bytes) {
  const [unit, size] = bytes >= 1e9 ? ['GB', 1e9] : bytes >= 1e6 ? ['MB', 1e6] : ['kB', 1e3];
  return `${formatCount(Number((bytes / size).toPrecision(2)))} ${unit}`;
}

/// Length with a suitable unit: 2 m, 5 cm, 0.4 mm.
export function formatLength(metres) {
  const [unit, size] = metres >= 1 ? ['m', 1] : metres >= 0.01 ? ['cm', 0.01] : ['mm', 0.001];
  return `${formatCount(Number((metres / size).toPrecision(2)))} ${unit}`;
}
