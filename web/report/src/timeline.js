// State shared by the charts, the view and the table: the visible time range and the current row.

// Smallest visible fraction of the run; below, only rounding errors are visible.
const smallestShare = 1e-6;

export class Timeline {
  #rangeListeners = [];
  #rowListeners = [];

  /// `x` are the times, non-empty and non-decreasing.
  constructor(x) {
    this.x = x;
    const [first, last] = [x[0], x[x.length - 1]];
    this.full = first < last ? [first, last] : [first - 0.5, first + 0.5];
    this.range = this.full;
    this.row = 0;
  }

  get isZoomed() {
    return this.range[0] > this.full[0] || this.range[1] < this.full[1];
  }

  onRange(listener) {
    this.#rangeListeners.push(listener);
  }

  onRow(listener) {
    this.#rowListeners.push(listener);
  }

  /// Sets the visible range to [from, to], limited to the run.
  setRange(from, to) {
    const [start, end] = this.full;
    const width = Math.max(Math.abs(to - from), smallestShare * (end - start));
    const middle = 0.5 * (from + to);
    const min = Math.min(Math.max(start, middle - 0.5 * width), end - smallestShare * (end - start));
    const max = Math.max(Math.min(end, middle + 0.5 * width), min + smallestShare * (end - start));
    this.range = [min, max];
    this.#rangeListeners.forEach((listener) => listener(this.range));
  }

  reset() {
    this.setRange(...this.full);
  }

  /// Moves the visible range without changing its width.
  pan(distance) {
    const [min, max] = this.range;
    const room = distance < 0 ? this.full[0] - min : this.full[1] - max;
    const step = distance < 0 ? Math.max(distance, room) : Math.min(distance, room);
    this.setRange(min + step, max + step);
  }

  /// Scales the visible range about `centre`; a factor below 1 zooms in.
  zoom(factor, centre) {
    const [min, max] = this.range;
    this.setRange(centre - (centre - min) * factor, centre + (max - centre) * factor);
  }

  setRow(row) {
    this.row = Math.min(Math.max(row, 0), this.x.length - 1);
    this.#rowListeners.forEach((listener) => listener(this.row));
  }

  /// Row whose time is nearest to `time`; the first of several.
  nearestRow(time) {
    let [low, high] = [0, this.x.length - 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.x[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low > 0 && time - this.x[low - 1] <= this.x[low] - time ? low - 1 : low;
  }
}
