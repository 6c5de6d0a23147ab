// Holding the tool by keyboard and gamepad, while the button `Hold` is on: arrows, Page Up and Page Down move it; A, D,
// W, S, Q and E rotate it.

import { Quaternion, Vector3 } from 'three';

import { isDialogOpen } from './shortcuts.js';

const speed = 2; // in tool sizes per second
const slow = 0.25; // factor on it with Shift
const turnSpeed = 1.2; // Unit: [rad/s].
const deadZone = 0.12; // of a stick
const longestFrame = 0.1; // largest time step, so that a stalled page does not leap. Unit: [s].
const moves = { // right, up, away
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowDown: [0, -1, 0], ArrowUp: [0, 1, 0],
  PageDown: [0, 0, -1], PageUp: [0, 0, 1],
};

const turns = { // about the camera's right, up and forward
  w: [-1, 0, 0], s: [1, 0, 0], a: [0, -1, 0], d: [0, 1, 0], q: [0, 0, -1], e: [0, 0, 1],
};

const isField = (node) => node instanceof HTMLElement && node.matches('input, select, textarea');
const nameOf = ({ key }) => (key.length === 1 ? key.toLowerCase() : key);
const live = (value) => (Math.abs(value) > deadZone ? value : 0);

export class Keys {
  #down = new Set();
  #last = 0;

  constructor(view, hold, felt) {
    Object.assign(this, { view, hold, felt });
    window.addEventListener('keydown', (event) => {
      const name = nameOf(event);
      if (!hold.holds('keys') || !(name in moves || name in turns) || isField(event.target) || isDialogOpen()) return;
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      this.#down.add(name);
      this.slowly = event.shiftKey;
      event.preventDefault();
    });
    window.addEventListener('keyup', (event) => {
      this.#down.delete(nameOf(event));
      this.slowly = event.shiftKey;
    });
    window.addEventListener('blur', () => this.#down.clear());
  }

  /// Call before every frame.
  update(now) {
    const seconds = Math.min(now - this.#last, longestFrame);
    this.#last = now;
    if (isDialogOpen()) this.#down.clear();
    if (!this.hold.holds('keys')) return;
    const wanted = this.#sum(moves);
    const pad = this.gamepad;
    if (pad) this.#addSticks(pad, wanted, seconds);
    const step = speed * this.felt.size * seconds * (this.slowly ? slow : 1);
    const { right, up, forward } = this.view.axesOfCamera;
    this.hold.hand.addScaledVector(right, step * wanted[0])
      .addScaledVector(up, step * wanted[1]).addScaledVector(forward, step * wanted[2]);
    this.#turn([right, up, forward], turnSpeed * seconds * (this.slowly ? slow : 1));
  }

  // Sum of the table's entries of all pressed keys.
  #sum(table) {
    return [0, 1, 2].map((k) => [...this.#down].reduce((sum, key) => sum + (table[key]?.[k] ?? 0), 0));
  }

  #turn(axes, angle) {
    this.#sum(turns).forEach((share, k) => {
      if (share !== 0) this.hold.orientation.premultiply(new Quaternion().setFromAxisAngle(axes[k], share * angle));
    });
  }

  // Left stick: motion in the plane of the screen. Right stick: motion in depth, and rotation about the vertical.
  #addSticks({ axes }, wanted, seconds) {
    wanted[0] += live(axes[0] ?? 0);
    wanted[1] -= live(axes[1] ?? 0);
    wanted[2] -= live(axes[3] ?? 0);
    const turn = new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), -turnSpeed * seconds * live(axes[2] ?? 0));
    this.hold.orientation.premultiply(turn);
  }

  get gamepad() {
    return navigator.getGamepads?.().find((pad) => pad?.mapping === 'standard') ?? null;
  }
}
