// A point of the felt surface that a person clicks, and marks at such points.

import { BufferAttribute, BufferGeometry, Points, PointsMaterial } from 'three';

const clickRoom = 5; // a press that moves farther turns the view. Unit: [px].

export class Picker {
  #waiting = null;

  constructor(view, splats, onMiss) {
    const { canvas } = view;
    let down = null;
    const material = new PointsMaterial({ size: 10, sizeAttenuation: false, depthTest: false, transparent: true });
    material.userData.color = '--accent';
    this.marks = new Points(new BufferGeometry(), material);
    this.marks.frustumCulled = false;
    this.marks.renderOrder = 9;
    this.view = view;
    canvas.addEventListener('pointerdown', (event) => { down = event; });
    canvas.addEventListener('pointerup', (event) => {
      if (!this.#waiting || !down || Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) > clickRoom) return;
      const point = splats.pick(view.rayAt(event));
      if (point) this.#settle(point);
      else onMiss();
    });
    window.addEventListener('keydown', ({ key }) => { if (key === 'Escape') this.#settle(null); });
  }

  /// The next point that is clicked, in the world; null if something else comes first.
  point() {
    this.#settle(null);
    this.view.canvas.classList.add('picking');
    return new Promise((resolve) => { this.#waiting = resolve; });
  }

  #settle(point) {
    this.view.canvas.classList.remove('picking');
    this.#waiting?.(point);
    this.#waiting = null;
  }

  /// Shows marks at points of the world.
  mark(points) {
    this.marks.geometry.setAttribute('position', new BufferAttribute(new Float32Array(points.flatMap((p) => p.toArray())), 3));
    this.view.invalidate();
  }
}
