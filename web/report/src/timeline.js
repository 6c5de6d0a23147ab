// What all charts, the view and the table share: the visible stretch of time and the current row.

// Zooming in further than this share of the run shows nothing but rounding.
const smallestShare = 1e-6;

export class Timeline {
  #rangeListeners = [];
  #rowListeners = [];

  /// `x` is not empty and does not decrease.
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

  /// Shows [from, to], as far as the run reaches.
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

  /// Moves the visible stretch without changing its width.
  pan(distance) {
    const [min, max] = this.range;
    const room = distance < 0 ? this.full[0] - min : this.full[1] - max;
    const step = distance < 0 ? Math.max(distance, room) : Math.min(distance, room);
    this.setRange(min + step, max + step);
  }

  /// Scales the visible stretch about `centre`; a factor below 1 zooms in.
  zoom(factor, centre) {
    const [min, max] = this.range;
    this.setRange(centre - (centre - min) * factor, centre + (max - centre) * factor);
  }

  setRow(row) {
    this.row = Math.min(Math.max(row, 0), this.x.length - 1);
    this.#rowListeners.forEach((listener) => listener(this.row));
  }

  /// The row whose time is nearest to `time`; the first of several.
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
