// The kept Gaussians around a point that moves: chosen anew when it has moved a while, not at every step.

const movedShare = 0.25; // of the way to the farthest chosen one, after which they are chosen anew

export class Neighbourhood {
  rows = [];
  #at = null; // the point that they are nearest to, and how far they reach from it
  #reach = 0;

  forget() {
    this.#at = null;
  }

  /// The `most` of `kept` nearest to `point`, a Vector3 in its frame. Returns whether they were chosen anew.
  follow(kept, point, most) {
    if (this.#at && point.distanceTo(this.#at) <= movedShare * this.#reach) return false;
    this.rows = [...kept.nearest(point.toArray(), most)];
    this.#at = point.clone();
    this.#reach = this.rows.length === kept.count ? Infinity : this.rows.reduce((far, row) => Math.max(far, distance(kept.at(row), point)), 0);
    return true;
  }
}

const distance = ({ position: [x, y, z] }, point) => Math.hypot(x - point.x, y - point.y, z - point.z);
