// Numbers as text, where the viewer needs them otherwise than other pages.

import { formatCount, isNumber, missing, withMinus } from '../../shared/format.js';

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
  return `${formatCount(Number((metres / size).toPrecision(2)))} ${unit}`;
}
