// Distance of a camera that centres some points in its view and keeps others visible.

const steps = 40; // number of bisections
const farthest = 1e9; // largest distance that is tried

/// Points are [right, up, forward] in the axes of a camera at `distance` behind the origin. At depth d it sees the
/// range `low` d to `high` d vertically, and -`side` d to `side` d horizontally.
export class Frame {
  constructor({ low, high, side, inside, beside = [] }) {
    Object.assign(this, { low, high, side, inside, beside });
  }

  /// Position {right, up} of the camera that centres the points `inside` in the view.
  middleAt(distance) {
    const [right, up] = this.#rooms(this.inside, distance).map(([least, most]) => 0.5 * (least + most));
    return { right, up };
  }

  /// Least distance at which all points are visible.
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

  // Ranges of camera positions, right and up, from which all `corners` are visible: [least, most] each.
  #rooms(corners, distance) {
    const between = (axis, from, to) => [
      Math.max(...corners.map((c) => c[axis] - to * (distance + c[2]))), Math.min(...corners.map((c) => c[axis] - from * (distance + c[2])))];
    return [between(0, -this.side, this.side), between(1, this.low, this.high)];
  }
}
