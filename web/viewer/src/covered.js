// What the parts of the page that lie on the view take of it. They are measured when the size of one changes: the browser lays the
// page out anew for each measurement.

const parts = '.bar > *, #stop, #hint, .panels';
const sideRoom = 30; // to both sides of a place, that a mark takes. Unit: [px].

export class Covered {
  #view = null; // where it is on the page
  #above = []; // the parts that lie on its upper half, and on its lower half
  #below = [];

  constructor(canvas) {
    this.canvas = canvas;
    this.nodes = [...document.querySelectorAll(parts)];
    const observer = new ResizeObserver(() => this.measure());
    for (const node of [canvas, ...this.nodes]) observer.observe(node);
  }

  /// To be called where the page has just changed; else it is found out after the next frame.
  measure() {
    this.#view = this.canvas.getBoundingClientRect();
    const { left, right, top, bottom } = this.#view;
    const boxes = this.nodes.filter((node) => !node.matches('.panels:not(.closed)')).map((node) => node.getBoundingClientRect())
      .filter((box) => box.right > left && box.left < right && box.bottom > top && box.height > 0);
    const isAbove = (box) => box.top + box.bottom < top + bottom;
    this.#above = boxes.filter(isAbove);
    this.#below = boxes.filter((box) => !isAbove(box));
  }

  /// From above and from below, {top, bottom}, at most some shares of the view's height. Unit: [px].
  rows(most) {
    this.measure();
    const { top, bottom, height } = this.#view;
    return {
      top: Math.min(most.top * height, Math.max(0, ...this.#above.map((box) => box.bottom - top))),
      bottom: Math.min(most.bottom * height, Math.max(0, ...this.#below.map((box) => bottom - box.top))),
    };
  }

  /// From above and from below, {top, bottom}, near `x` of the page; anywhere, where that is null. Unit: [px].
  near(x) {
    if (!this.#view) this.measure();
    const isNear = ({ left, right }) => x === null || (x > left - sideRoom && x < right + sideRoom);
    return {
      top: Math.max(0, ...this.#above.filter(isNear).map((box) => box.bottom - this.#view.top)),
      bottom: Math.max(0, ...this.#below.filter(isNear).map((box) => this.#view.bottom - box.top)),
    };
  }
}
