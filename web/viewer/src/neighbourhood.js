// The kept Gaussians around a moving point, updated only after the point has moved far enough.

const movedShare = 0.25; // motion that triggers an update, relative to the distance of the farthest selected Gaussian

export class Neighbourhood {
  rows = [];
  #at = null; // query point of the selection; #reach is the distance of the farthest one
  #reach = 0;

  forget() {
    this.#at = null;
  }

  /// Selects the `most` of `kept` nearest to `point`, a Vector3 in its frame. Returns whether it was updated.
  follow(kept, point, most) {
    if (this.#at && point.distanceTo(this.#at) <= movedShare * this.#reach) return false;
    this.rows = [...kept.nearest(point.toArray(), most)];
    this.#at = point.clone();
    this.#reach = this.rows.length === kept.count ? Infinity : this.rows.reduce((far, row) => Math.max(far, distance(kept.at(row), point)), 0);
    return true;
  }
}

const distance = ({ position: [x, y, z] }, point) => Math.hypot(x - point.x, y - point.y, z - point.z);
