// Acceleration structure for rays: blocks of neighbouring Gaussians, each with a bounding box of their visible extents.

const bits = 6; // bits of a cell index along each axis
const cells = 1 << bits;
const block = 128; // Gaussians per block
const sample = 50000; // Gaussians sampled for the grid
const outermost = 0.01; // fraction at each end of an axis that is clamped to the border cells
const large = 2; // reach in cells above which a Gaussian is stored separately, as it would enlarge its block's box

// Bits of an index spread to every third place: interleaved x, y and z give a Morton order.
const spread = Uint32Array.from({ length: cells }, (_, n) => Array.from({ length: bits }, (_, k) => ((n >> k) & 1) << (3 * k)).reduce((a, b) => a | b));

export class RayBlocks {
  #rows;
  #boxes; // per block: least x, y, z, greatest x, y, z

  /// `data` has `stride` numbers per Gaussian, the first three its centre; `reach(row)` is its visible radius.
  constructor(data, stride, reach) {
    this.#rows = inOrder(data, stride, reach);
    this.#boxes = boxesOf(this.#rows, data, stride, reach);
  }

  /// Calls `see(row)` for a superset of the Gaussians that a ray meets.
  visit(origin, direction, see) {
    const rows = this.#rows;
    for (let first = 0, at = 0; first < rows.length; first += block, at += 6) {
      if (!this.#meets(at, origin, direction)) continue;
      const end = Math.min(first + block, rows.length);
      for (let i = first; i < end; ++i) see(rows[i]);
    }
  }

  #meets(at, origin, direction) {
    let [enters, leaves] = [0, Infinity];
    for (let k = 0; k < 3; ++k) {
      const [least, most] = [this.#boxes[at + k] - origin[k], this.#boxes[at + 3 + k] - origin[k]];
      const d = direction[k];
      if (d === 0) {
        if (least > 0 || most < 0) return false;
        continue;
      }
      enters = Math.max(enters, (d > 0 ? least : most) / d);
      leaves = Math.min(leaves, (d > 0 ? most : least) / d);
    }
    return enters <= leaves;
  }
}

// Rows sorted by the cell of their centre; large Gaussians last.
function inOrder(data, stride, reach) {
  const count = data.length / stride;
  const step = Math.ceil(count / sample);
  const axes = [0, 1, 2].map((k) => {
    const values = Float32Array.from({ length: Math.ceil(count / Math.max(step, 1)) }, (_, i) => data[stride * step * i + k]).sort();
    const at = (share) => values[Math.round(share * (values.length - 1))];
    return { from: at(outermost), width: (at(1 - outermost) - at(outermost)) / cells };
  });
  const width = Math.max(...axes.map((axis) => axis.width));
  const keys = new Uint32Array(count);
  const counts = new Uint32Array(cells ** 3 + 2);
  for (let row = 0; row < count; ++row) {
    let key = 0;
    for (let k = 0; k < 3; ++k) {
      const cell = (data[stride * row + k] - axes[k].from) / axes[k].width;
      key |= spread[cell > 0 ? Math.min(Math.floor(cell), cells - 1) : 0] << k;
    }
    keys[row] = reach(row) > large * width ? cells ** 3 : key;
    ++counts[keys[row] + 1];
  }
  for (let key = 1; key < counts.length; ++key) counts[key] += counts[key - 1];
  const rows = new Uint32Array(count);
  for (let row = 0; row < count; ++row) rows[counts[keys[row]]++] = row;
  return rows;
}

function boxesOf(rows, data, stride, reach) {
  const boxes = new Float32Array(6 * Math.ceil(rows.length / block));
  for (let i = 0; i < rows.length; ++i) {
    const at = 6 * Math.floor(i / block);
    if (i % block === 0) for (let k = 0; k < 3; ++k) [boxes[at + k], boxes[at + 3 + k]] = [Infinity, -Infinity];
    const room = reach(rows[i]);
    for (let k = 0; k < 3; ++k) {
      const centre = data[stride * rows[i] + k];
      if (centre - room < boxes[at + k]) boxes[at + k] = centre - room;
      if (centre + room > boxes[at + 3 + k]) boxes[at + 3 + k] = centre + room;
    }
  }
  return boxes;
}
