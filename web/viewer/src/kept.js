// The Gaussians that the program's filter has kept, as the ellipsoids that can be felt. In the frame of the capture.

import { extentOf } from './extent.js';
import { RayBlocks } from './ray_blocks.js';

const stride = 11; // numbers per Gaussian: centre, standard deviations, rotation as x, y, z, w, opacity
const boxSample = 50000; // number of Gaussians sampled for the box
const cutoff = 3; // distance from the centre beyond which a ray does not see a Gaussian. Unit: [standard deviations].
const leastThickness = 1e-3; // least axis of a Gaussian relative to its longest: some are flat
const rounding = 1.0001; // factor on visible radii, against rounding in single precision
const leastSeen = 0.2; // least opacity of a visible surface along a ray

/// Reads a SplatMesh once.
export function readGaussians(mesh) {
  const data = new Float32Array(stride * mesh.numSplats);
  mesh.forEachSplat((i, centre, scales, rotation, opacity) => {
    centre.toArray(data, stride * i);
    scales.toArray(data, stride * i + 3);
    rotation.toArray(data, stride * i + 6);
    data[stride * i + 10] = opacity;
  });
  return new Kept(data);
}

export class Kept {
  #data;
  #rows = new Uint32Array(0); // rows of the kept Gaussians
  #isKept; // 1 for kept Gaussians, by row
  #semiAxes; // semi-axes of the ellipsoids, by row
  #box = null;
  #blocks;

  constructor(data) {
    this.#data = data;
    this.#isKept = new Uint8Array(data.length / stride);
    this.#semiAxes = new Float32Array(3 * (data.length / stride));
    this.#blocks = new RayBlocks(data, stride, (row) => rounding * this.#reach(row));
  }

  get count() {
    return this.#rows.length;
  }

  /// Sets the kept Gaussians. `list` is an ArrayBuffer: row (uint32) and three semi-axes (float32) of each.
  keep(list) {
    const [rows, values] = [new Uint32Array(list), new Float32Array(list)];
    const known = this.#data.length / stride;
    this.#rows = rows.filter((row, i) => i % 4 === 0 && row < known);
    this.#isKept.fill(0);
    for (const row of this.#rows) this.#isKept[row] = 1;
    for (let i = 0; i < rows.length; i += 4) if (rows[i] < known) this.#semiAxes.set(values.subarray(i + 1, i + 4), 3 * rows[i]);
    this.#box = this.#findBox();
  }

  at(row) {
    const d = this.#data.subarray(stride * row, stride * (row + 1));
    return { row, position: d.slice(0, 3), semiAxes: this.#semiAxes.slice(3 * row, 3 * row + 3), orientation: d.slice(6, 10) };
  }

  /// Rows of the `most` kept Gaussians whose centres are nearest to a point.
  nearest([x, y, z], most) {
    if (this.count <= most) return this.#rows;
    const data = this.#data;
    const squares = new Float32Array(this.count);
    this.#rows.forEach((row, i) => {
      const at = stride * row;
      squares[i] = (data[at] - x) ** 2 + (data[at + 1] - y) ** 2 + (data[at + 2] - z) ** 2;
    });
    return firstOf(this.#rows, squares, most);
  }

  /// Box of most of the kept centres, see extentOf(): {min, max}; null if there are none.
  get box() {
    return this.#box;
  }

  #findBox() {
    if (this.count === 0) return null;
    const step = Math.ceil(this.count / boxSample);
    const some = this.#rows.filter((_, i) => i % step === 0);
    return extentOf(Float32Array.from({ length: 3 * some.length }, (_, i) => this.#data[stride * some[Math.floor(i / 3)] + (i % 3)]));
  }

  /// Visible surface along a ray, at half of its opacity: {distance in units of `direction`, felt, opacity}, or null.
  /// `felt` is true if most of the opacity up to there is of kept Gaussians; `opacity` is that of the whole ray.
  hit(origin, direction) {
    return this.#half(this.#along(origin, direction));
  }

  /// The same for the kept Gaussians only.
  hitKept(origin, direction) {
    return this.#half(this.#along(origin, direction).filter(({ row }) => this.#isKept[row]));
  }

  #half(seen) {
    let left = 1;
    for (const one of seen) {
      one.weight = left * one.alpha;
      left -= one.weight;
    }
    if (1 - left < leastSeen) return null;
    let [sum, kept] = [0, 0];
    for (const { row, distance, weight } of seen) {
      sum += weight;
      if (this.#isKept[row]) kept += weight;
      if (2 * sum >= 1 - left) return { distance, felt: 2 * kept >= sum, opacity: 1 - left };
    }
    return null;
  }

  /// Opacity along a ray up to a distance, in units of `direction`.
  opacityBefore(origin, direction, distance) {
    const left = this.#along(origin, direction).reduce((share, one) => (one.distance < distance ? share * (1 - one.alpha) : share), 1);
    return 1 - left;
  }

  /// Nearest point of the ellipsoids of `rows`, approximated by their boxes: {point, distance}, or null.
  closest(rows, position) {
    let [nearest, least] = [null, Infinity];
    for (const row of rows) {
      const d = this.#data.subarray(stride * row, stride * (row + 1));
      const turn = [d[6], d[7], d[8], d[9]];
      const local = rotate(conjugate(turn), [position[0] - d[0], position[1] - d[1], position[2] - d[2]]);
      const inside = local.map((c, k) => Math.min(Math.max(c, -this.#semiAxes[3 * row + k]), this.#semiAxes[3 * row + k]));
      const distance = Math.hypot(local[0] - inside[0], local[1] - inside[1], local[2] - inside[2]);
      if (distance >= least) continue;
      least = distance;
      nearest = { distance, point: rotate(turn, inside).map((c, k) => c + d[k]) };
    }
    return nearest;
  }

  // Gaussians along a ray, front to back: {row, distance, alpha}.
  #along(origin, direction) {
    const met = [];
    this.#blocks.visit(origin, direction, (row) => this.#meet(row, origin, direction, met));
    return met.sort((a, b) => a.distance - b.distance);
  }

  // Visible radius of a Gaussian.
  #reach(row) {
    const at = stride * row;
    return cutoff * Math.max(this.#data[at + 3], this.#data[at + 4], this.#data[at + 5]);
  }

  // Computed in the frame where the Gaussian is isotropic: the t for which |o + t u| is least.
  #meet(row, origin, direction, met) {
    const at = stride * row;
    const d = this.#data;
    const offset = [origin[0] - d[at], origin[1] - d[at + 1], origin[2] - d[at + 2]];
    const reach = this.#reach(row);
    const along = dot(offset, direction) ** 2 / dot(direction, direction);
    if (dot(offset, offset) - along > reach * reach) return;
    const inverse = conjugate([d[at + 6], d[at + 7], d[at + 8], d[at + 9]]);
    const round = (v) => rotate(inverse, v).map((c, k) => c / Math.max(d[at + 3 + k], (leastThickness * reach) / cutoff));
    const [o, u] = [round(offset), round(direction)];
    const distance = -dot(o, u) / dot(u, u);
    const nearest = o.map((c, k) => c + distance * u[k]); // a difference of squares would cancel for a thin one
    const least = dot(nearest, nearest);
    if (distance >= 0 && least < cutoff * cutoff) met.push({ row, distance, alpha: d[at + 10] * Math.exp(-0.5 * least) });
  }
}

// The `most` of `rows` with the smallest `keys`, which are positive; keys within 1 % of the last one are not
// distinguished. Counts the upper bits of the floats, which are monotonic for positive ones: sorting millions would
// block the page.
function firstOf(rows, keys, most) {
  const bits = new Uint32Array(keys.buffer);
  const counts = new Uint32Array(1 << 16);
  for (const b of bits) ++counts[b >>> 16];
  let last = 0;
  let left = most; // remaining count of rows with the upper bits `last`
  for (; counts[last] < left; ++last) left -= counts[last];
  return rows.filter((_, i) => bits[i] >>> 16 < last || (bits[i] >>> 16 === last && left-- > 0));
}

const conjugate = ([x, y, z, w]) => [-x, -y, -z, w];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// v rotated by a unit quaternion: v + 2 q x (q x v + w v).
function rotate([x, y, z, w], v) {
  const t = [y * v[2] - z * v[1] + w * v[0], z * v[0] - x * v[2] + w * v[1], x * v[1] - y * v[0] + w * v[2]];
  return [
    v[0] + 2 * (y * t[2] - z * t[1]),
    v[1] + 2 * (z * t[0] - x * t[2]),
    v[2] + 2 * (x * t[1] - y * t[0]),
  ];
}
