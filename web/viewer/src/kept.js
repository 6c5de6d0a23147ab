// What the hand can feel: the Gaussians that the program has kept, as ellipsoids. In the frame of the capture.

const stride = 10; // of a Gaussian: centre, standard deviations, rotation as x, y, z, w
const boxSample = 50000; // Gaussians that say where the others are
const middle = 2; // how near to its centre a ray must pass to meet it. Unit: [standard deviations].

/// Reads a SplatMesh once.
export function readGaussians(mesh) {
  const data = new Float32Array(stride * mesh.numSplats);
  mesh.forEachSplat((i, centre, scales, rotation) => {
    centre.toArray(data, stride * i);
    scales.toArray(data, stride * i + 3);
    rotation.toArray(data, stride * i + 6);
  });
  return new Kept(data);
}

export class Kept {
  #data;
  #rows = new Uint32Array(0); // of the kept ones
  #semiAxes; // of the ellipsoids, by row
  #box = null;

  constructor(data) {
    this.#data = data;
    this.#semiAxes = new Float32Array(3 * (data.length / stride));
  }

  get count() {
    return this.#rows.length;
  }

  /// `list` is an ArrayBuffer as the program gives it: of each Gaussian its row (uint32) and its three semi-axes
  /// (float32).
  keep(list) {
    const [rows, values] = [new Uint32Array(list), new Float32Array(list)];
    const known = this.#data.length / stride;
    this.#rows = rows.filter((row, i) => i % 4 === 0 && row < known);
    for (let i = 0; i < rows.length; i += 4) if (rows[i] < known) this.#semiAxes.set(values.subarray(i + 1, i + 4), 3 * rows[i]);
    this.#box = this.#findBox();
  }

  at(row) {
    const d = this.#data.subarray(stride * row, stride * (row + 1));
    return { row, position: d.slice(0, 3), semiAxes: this.#semiAxes.slice(3 * row, 3 * row + 3), orientation: d.slice(6, 10) };
  }

  /// The rows of the `most` kept Gaussians whose centres are nearest to a point.
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

  /// The box that all but the outermost hundredth of the kept centres lie in along each axis: captures have a few
  /// Gaussians far away. {min, max}, or null if there are none.
  get box() {
    return this.#box;
  }

  #findBox() {
    if (this.count === 0) return null;
    const step = Math.ceil(this.count / boxSample);
    const some = this.#rows.filter((_, i) => i % step === 0);
    const sorted = [0, 1, 2].map((k) => Float32Array.from(some, (row) => this.#data[stride * row + k]).sort());
    const at = (share) => sorted.map((values) => values[Math.round(share * (values.length - 1))]);
    return { min: at(0.01), max: at(0.99) };
  }

  /// Where a ray first passes through the middle of a kept Gaussian: the distance in units of `direction`, or null.
  /// It is the densest point of the ray, which lies on the surface that is seen even where ellipsoids leave gaps.
  hit(origin, direction) {
    let nearest = Infinity;
    for (const row of this.#rows) {
      const distance = this.#distance(stride * row, origin, direction);
      if (distance < nearest) nearest = distance;
    }
    return nearest < Infinity ? nearest : null;
  }

  // In the frame where the Gaussian is round: where |o + t d| is least, if that is small.
  #distance(at, origin, direction) {
    const d = this.#data;
    const offset = [origin[0] - d[at], origin[1] - d[at + 1], origin[2] - d[at + 2]];
    const reach = middle * Math.max(d[at + 3], d[at + 4], d[at + 5]);
    const along = dot(offset, direction) ** 2 / dot(direction, direction);
    if (dot(offset, offset) - along > reach * reach) return Infinity;
    const inverse = [-d[at + 6], -d[at + 7], -d[at + 8], d[at + 9]];
    const round = (v) => rotate(inverse, v).map((c, k) => c / d[at + 3 + k]);
    const [o, u] = [round(offset), round(direction)];
    const distance = -dot(o, u) / dot(u, u);
    const least = dot(o, o) - distance * distance * dot(u, u);
    return distance >= 0 && least < middle * middle ? distance : Infinity;
  }
}

// `most` of `rows` with the least `keys`, which are positive; those within a hundredth of the last are in no order.
// Sorting millions would hold up the page: the upper bits of a positive float, which grow with it, are counted.
function firstOf(rows, keys, most) {
  const bits = new Uint32Array(keys.buffer);
  const counts = new Uint32Array(1 << 16);
  for (const b of bits) ++counts[b >>> 16];
  let last = 0;
  let left = most; // for what has the upper bits `last`
  for (; counts[last] < left; ++last) left -= counts[last];
  return rows.filter((_, i) => bits[i] >>> 16 < last || (bits[i] >>> 16 === last && left-- > 0));
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// v turned by a unit quaternion: v + 2 q x (q x v + w v).
function rotate([x, y, z, w], v) {
  const t = [y * v[2] - z * v[1] + w * v[0], z * v[0] - x * v[2] + w * v[1], x * v[1] - y * v[0] + w * v[2]];
  return [
    v[0] + 2 * (y * t[2] - z * t[1]),
    v[1] + 2 * (z * t[0] - x * t[2]),
    v[2] + 2 * (x * t[1] - y * t[0]),
  ];
}
