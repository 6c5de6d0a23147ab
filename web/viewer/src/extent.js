// Extent of the main part of a scene. Captures have outlying Gaussians and surrounding haze.

const reach = 0.4; // margin around the inner 80 %, relative to their width: does not cut uniform scenes and balls
const cellShare = 1 / 24; // size of a cell relative to the width of the inner 80 %
const [solidShare, leastSolid] = [0.3, 2]; // least content of a solid cell: relative to a typical one, and absolute
const farthest = 511; // largest distance of a cell from the middle, in cells

/// Returns the box {min, max} of `positions` (x, y, z, x, ...) without the outermost 1 % at each end of each axis,
/// limited to a margin of `reach` around the inner 80 %; extended by solid parts connected to it, such as a head on a
/// body.
export function extentOf(positions) {
  const sorted = [0, 1, 2].map((k) => Float32Array.from({ length: positions.length / 3 }, (_, i) => positions[3 * i + k]).sort());
  const at = (share) => sorted.map((values) => values[Math.round(share * (values.length - 1))]);
  const [least, low, middle, high, most] = [0.01, 0.1, 0.5, 0.9, 0.99].map(at);
  const room = low.map((c, k) => reach * (high[k] - c));
  const box = { min: least.map((c, k) => Math.max(c, low[k] - room[k])), max: most.map((c, k) => Math.min(c, high[k] + room[k])) };
  const width = Math.max(...high.map((c, k) => c - low[k]));
  return width > 0 ? withWhatGoesOn(box, cellsOf(positions, middle, cellShare * width)) : box;
}

// Cells by key: the number of Gaussians of each, and the bounding box of their centres.
function cellsOf(positions, origin, width) {
  const cells = new Map();
  for (let i = 0; i < positions.length; i += 3) {
    const p = [positions[i], positions[i + 1], positions[i + 2]];
    const at = p.map((c, k) => Math.floor((c - origin[k]) / width));
    if (Math.max(...at.map(Math.abs)) >= farthest) continue;
    const key = keyOf(at);
    const cell = cells.get(key);
    if (!cell) cells.set(key, { at, count: 1, min: p, max: [...p] });
    else {
      ++cell.count;
      for (let k = 0; k < 3; ++k) {
        cell.min[k] = Math.min(cell.min[k], p[k]);
        cell.max[k] = Math.max(cell.max[k], p[k]);
      }
    }
  }
  return cells;
}

const keyOf = (at) => at.reduce((key, c) => key * 2 * (farthest + 1) + c + farthest + 1, 0);

// Extends a box by the solid cells connected to those that it overlaps.
function withWhatGoesOn(box, cells) {
  const solid = Math.max(leastSolid, solidShare * usualCount(cells));
  const meets = ({ min, max }) => min.every((c, k) => c <= box.max[k] && max[k] >= box.min[k]);
  const found = [...cells.values()].filter((cell) => cell.count >= solid && meets(cell));
  const known = new Set(found);
  while (found.length > 0) {
    const { at } = found.pop();
    for (let i = 0; i < 27; ++i) {
      const cell = cells.get(keyOf([at[0] + (i % 3) - 1, at[1] + (Math.floor(i / 3) % 3) - 1, at[2] + Math.floor(i / 9) - 1]));
      if (!cell || cell.count < solid || known.has(cell)) continue;
      known.add(cell);
      found.push(cell);
    }
  }
  const outside = [...known].filter((cell) => !meets(cell));
  return { // cells on the border of the box do not extend it
    min: box.min.map((c, k) => outside.reduce((least, { min }) => Math.min(least, min[k]), c)),
    max: box.max.map((c, k) => outside.reduce((most, { max }) => Math.max(most, max[k]), c)),
  };
}

// Number of Gaussians in the cell of the median Gaussian.
function usualCount(cells) {
  const counts = [...cells.values()].map((cell) => cell.count).sort((a, b) => a - b);
  const all = counts.reduce((sum, count) => sum + count, 0);
  let sum = 0;
  return counts.find((count) => { sum += count; return 2 * sum >= all; });
}
