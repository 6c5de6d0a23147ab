// Area of the view covered by other elements of the page. Measured only when the size of one changes, because each
// measurement forces a layout.

const parts = '.bar > *, #stop, #hint, .panels';
const sideRoom = 30; // half width of a mark. Unit: [px].

export class Covered {
  #view = null; // rectangle on the page
  #above = []; // rectangles of the elements on its upper half, and on its lower half
  #below = [];

  constructor(canvas) {
    this.canvas = canvas;
    this.nodes = [...document.querySelectorAll(parts)];
    const observer = new ResizeObserver(() => this.measure());
    for (const node of [canvas, ...this.nodes]) observer.observe(node);
  }

  /// Call after a change of the page; otherwise the change is noticed after the next frame.
  measure() {
    this.#view = this.canvas.getBoundingClientRect();
    const { left, right, top, bottom } = this.#view;
    const boxes = this.nodes.filter((node) => !node.matches('.panels:not(.closed)')).map((node) => node.getBoundingClientRect())
      .filter((box) => box.right > left && box.left < right && box.bottom > top && box.height > 0);
    const isAbove = (box) => box.top + box.bottom < top + bottom;
    this.#above = boxes.filter(isAbove);
    this.#below = boxes.filter((box) => !isAbove(box));
  }

  /// Covered heights {top, bottom}, limited to the fractions `most` of the view's height. Unit: [px].
  rows(most) {
    this.measure();
    const { top, bottom, height } = this.#view;
    return {
      top: Math.min(most.top * height, Math.max(0, ...this.#above.map((box) => box.bottom - top))),
      bottom: Math.min(most.bottom * height, Math.max(0, ...this.#below.map((box) => bottom - box.top))),
    };
  }

  /// Covered heights {top, bottom} near `x` on the page; over the whole width if it is null. Unit: [px].
  near(x) {
    if (!this.#view) this.measure();
    const isNear = ({ left, right }) => x === null || (x > left - sideRoom && x < right + sideRoom);
    return {
      top: Math.max(0, ...this.#above.filter(isNear).map((box) => box.bottom - this.#view.top)),
      bottom: Math.max(0, ...this.#below.filter(isNear).map((box) => this.#view.bottom - box.top)),
    };
  }
}
