// Picking of points on the felt surface for a measurement, and marks at these points.

import { BufferAttribute, BufferGeometry, Points, PointsMaterial } from 'three';

import { cancelledByEscape } from './escape.js';

export class Picker {
  #waiting = null;
  #forget = () => {};

  constructor(view) {
    const material = new PointsMaterial({ size: 10, sizeAttenuation: false, depthTest: false, transparent: true });
    material.userData.color = '--accent';
    this.marks = new Points(new BufferGeometry(), material);
    this.marks.frustumCulled = false;
    this.marks.renderOrder = 9;
    this.view = view;
  }

  get waits() {
    return this.#waiting !== null;
  }

  /// Resolves to the next picked point, in the world; null if picking is cancelled or restarted.
  point() {
    this.give(null);
    this.view.canvas.classList.add('picking');
    return new Promise((resolve) => {
      this.#waiting = resolve;
      this.#forget = cancelledByEscape(() => this.give(null));
    });
  }

  give(point) {
    this.view.canvas.classList.remove('picking');
    this.#forget();
    this.#waiting?.(point);
    this.#waiting = null;
  }

  /// Shows marks at points of the world.
  mark(points) {
    this.marks.geometry.setAttribute('position', new BufferAttribute(new Float32Array(points.flatMap((p) => p.toArray())), 3));
    this.view.invalidate();
  }
}
