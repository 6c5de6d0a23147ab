// Numbers as text, where the viewer needs them otherwise than other pages.

import { formatCount, isNumber, missing, withMinus } from '../../shared/format.js';

export function formatFixed(value, decimals) {
  return isNumber(value) ? withMinus(value.toFixed(decimals)) : missing;
}

/// A number for a field: as short as it can be without showing rounding noise.
export function formatField(value) {
  return String(Number(value.toPrecision(6)));
}

/// The size of a file as people say it: 5.7 MB.
export function formatBytes(bytes) {
  const [unit, size] = bytes >= 1e9 ? ['GB', 1e9] : bytes >= 1e6 ? ['MB', 1e6] : ['kB', 1e3];
  return `${formatCount(Number((bytes / size).toPrecision(2)))} ${unit}`;
}

/// A length as people say it: 2 m, 5 cm, 0.4 mm.
export function formatLength(metres) {
  const [unit, size] = metres >= 1 ? ['m', 1] : metres >= 0.01 ? ['cm', 0.01] : ['mm', 0.001];
  return `${formatCount(Number((metres / size).toPrecision(2)))} ${unit}`;
}
