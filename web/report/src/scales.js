// Vertical scales and their ticks.

import { formatCount, niceFloor } from '../../shared/format.js';
import { formatTick, niceCeil } from './format.js';

const decadesForPlainTicks = 2.5;

/// Logarithmic scale that can show zeros: they are drawn at a floor below the smallest positive value, labelled 0.
export function logScale(columns) {
  const positives = columns.flatMap((c) => smallestPositive(c));
  const smallest = positives.length > 0 ? Math.min(...positives) : 1;
  const hasZeros = columns.some((c) => c.some((v) => v !== null && v <= 0));
  const floor = 0.5 * 10 ** Math.floor(Math.log10(smallest));
  return {
    toPlot: (column) => (hasZeros ? column.map((v) => (v === null || v > 0 ? v : floor)) : column),
    uplot: { distr: 3, log: 10, range: (_, min, max) => logRange(min, max, hasZeros ? floor : null) },
    splits: (_, __, min, max) => logSplits(min, max, hasZeros ? floor : null),
    label: (value) => (hasZeros && value === floor ? '0' : formatCount(value)),
  };
}

function smallestPositive(column) {
  let smallest = Infinity;
  for (const value of column) {
    if (value !== null && value > 0 && value < smallest) smallest = value;
  }
  return smallest < Infinity ? [smallest] : [];
}

function logRange(min, max, floor) {
  const high = max > 0 ? max : 1;
  const low = min > 0 ? min : high;
  // Margin below the floor, so that the frame does not clip a curve of zeros.
  const bottom = floor === null ? niceFloor(low) : 0.85 * floor;
  const top = niceCeil(high * 1.05);
  return [bottom, Math.max(top, 10 * niceCeil(bottom))];
}

function logSplits(min, max, floor) {
  const decades = Math.log10(max / min);
  const steps = decades < decadesForPlainTicks ? [1, 2, 5] : [1];
  const splits = floor === null ? [] : [floor];
  for (let decade = 10 ** Math.floor(Math.log10(min)); decade <= max; decade *= 10) {
    splits.push(...steps.map((step) => Number((step * decade).toPrecision(6))));
  }
  const above = floor === null ? min * (1 - 1e-9) : 1.5 * floor;
  return splits.filter((v) => v === floor || (v >= above && v <= max * (1 + 1e-9)));
}

/// A linear scale that always shows zero.
export function linearScale() {
  return {
    toPlot: (column) => column,
    uplot: { range: (_, min, max) => linearRange(min ?? 0, max ?? 0) },
    splits: undefined,
    label: formatTick,
  };
}

function linearRange(min, max) {
  const [low, high] = [Math.min(min, 0), Math.max(max, 0)];
  if (low === high) return [-1, 1];
  const pad = 0.08 * (high - low);
  return [low < 0 ? low - pad : low, high > 0 ? high + pad : high];
}
