// Frame times: mean and longest of the last second.

const window = 1; // averaging window. Unit: [s].

export class FrameTimes {
  mean = 0; // Unit: [s].
  longest = 0;
  #last = null;
  #began = 0;
  #count = 0;
  #worst = 0;

  /// Call once per frame. Unit: [s].
  add(now) {
    if (this.#last !== null) {
      this.#worst = Math.max(this.#worst, now - this.#last);
      this.#count += 1;
    } else this.#began = now;
    this.#last = now;
    if (now - this.#began < window || this.#count === 0) return;
    this.mean = (now - this.#began) / this.#count;
    this.longest = this.#worst;
    this.#began = now;
    this.#count = this.#worst = 0;
  }
}
