// How far a camera stands off so that it has something in the middle of its view, and something else in view beside it.

const steps = 40; // of bisection
const farthest = 1e9; // of all distances that are tried

/// Corners are [right, up, forward] of a camera that stands `distance` behind the origin. It sees what lies within `low` and `high`
/// times, to both sides `side` times, how far ahead it is.
export class Frame {
  constructor({ low, high, side, inside, beside = [] }) {
    Object.assign(this, { low, high, side, inside, beside });
  }

  /// Where the camera stands so that what is inside has as much room on all sides: {right, up}.
  middleAt(distance) {
    const [right, up] = this.#rooms(this.inside, distance).map(([least, most]) => 0.5 * (least + most));
    return { right, up };
  }

  /// From where on all is seen.
  leastDistance() {
    let near = Math.max(...this.inside.map(([, , forward]) => -forward));
    let far = Math.max(1, 2 * near) + 1e-3;
    while (!this.#sees(far) && far < farthest) far *= 2;
    for (let k = 0; k < steps; k += 1) {
      const between = 0.5 * (near + far);
      if (this.#sees(between)) far = between;
      else near = between;
    }
    return far;
  }

  #sees(distance) {
    if (!this.#rooms(this.inside, distance).every(([least, most]) => least <= most)) return false;
    if (this.beside.length === 0) return true;
    const { right, up } = this.middleAt(distance);
    return this.#rooms(this.beside, distance).every(([least, most], k) => least <= [right, up][k] && [right, up][k] <= most);
  }

  // Between where and where the camera stands, to the right and upward, to see some corners: [least, most] each.
  #rooms(corners, distance) {
    const between = (axis, from, to) => [
      Math.max(...corners.map((c) => c[axis] - to * (distance + c[2]))), Math.min(...corners.map((c) => c[axis] - from * (distance + c[2])))];
    return [between(0, -this.side, this.side), between(1, this.low, this.high)];
  }
}
