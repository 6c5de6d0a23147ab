// Holding the tool by mouse or touch: dragging moves it in the plane of the screen, with Ctrl rotates it; the wheel,
// the right button or a second finger moves it along the line of sight. A press on an object that hides the tool is a
// click on that object, unless Shift is pressed.

import { Quaternion, Raycaster, Vector3 } from 'three';

const wheelShare = 0.2; // motion per scrolled distance
const rightButton = 2;
const turnPerPixel = 0.01; // Unit: [rad/px].
const hiding = 0.5; // opacity in front of the tool from which on the tool counts as hidden
const sunk = 0.5; // ignored distance in front of the tool: the touched surface may cover a part. In tool sizes.
const reach = { mouse: 14, pen: 14, touch: 32 }; // radius around the handle that takes the tool. Unit: [px].

export class Drag {
  #pointers = new Map(); // last event, by pointerId
  #first = null; // id of the pointer that holds the tool

  constructor(view, hold, felt, splats) {
    Object.assign(this, { view, hold, felt, splats });
    const on = (name, react) => view.canvas.addEventListener(name, react, { capture: true, passive: false });
    on('pointerdown', (event) => this.#down(event));
    on('pointermove', (event) => this.#move(event));
    on('pointerup', (event) => this.#up(event));
    on('pointercancel', (event) => this.#up(event));
    on('wheel', (event) => this.#wheel(event));
    on('contextmenu', (event) => event.preventDefault());
    hold.onChange(() => { if (!hold.holds('pointer')) this.#forget(); });
  }

  // Needed when the hold is ended elsewhere: the pointer may never be released here.
  #forget() {
    this.#first = null;
    this.#pointers.clear();
    this.view.canvas.classList.remove('holding');
  }

  #catches(event) {
    if (event.shiftKey || this.hold.holds('keys')) return true;
    const caster = new Raycaster();
    caster.ray.copy(this.view.rayAt(event));
    const [hit] = caster.intersectObject(this.felt.tool);
    if (hit) return !this.#isHidden(caster.ray, hit.distance);
    if (!this.#isNear(event)) return false;
    const handle = new Vector3(...this.hold.live.tool.position);
    return !this.#isHidden(caster.ray, handle.sub(caster.ray.origin).dot(caster.ray.direction));
  }

  // Small tools can also be taken near their handle.
  #isNear({ clientX, clientY, pointerType }) {
    const { live } = this.hold;
    const at = live.isFresh('measured_cp') && this.view.project(live.tool.position);
    return Boolean(at) && Math.hypot(at[0] - clientX, at[1] - clientY) < (reach[pointerType] ?? reach.mouse);
  }

  // Whether the scene hides the tool, which is at `distance` along a ray.
  #isHidden({ origin, direction }, distance) {
    const before = Math.max(0, distance - sunk * this.felt.size);
    return this.splats.opacityBetween(origin, origin.clone().addScaledVector(direction, before)) > hiding;
  }

  #down(event) {
    if (this.#first !== null) {
      this.#pointers.set(event.pointerId, event);
      event.stopImmediatePropagation();
      return;
    }
    if (!this.#catches(event) || !this.hold.begin('pointer')) return;
    event.stopImmediatePropagation();
    this.view.canvas.focus({ preventScroll: true });
    this.view.canvas.setPointerCapture(event.pointerId);
    this.#first = event.pointerId;
    this.#pointers.set(event.pointerId, event);
    this.view.canvas.classList.add('holding');
  }

  #move(event) {
    const last = this.#pointers.get(event.pointerId);
    if (!last) {
      if (event.buttons === 0) this.view.canvas.classList.toggle('over-tool', this.#catches(event));
      return;
    }
    event.stopImmediatePropagation();
    const [dx, dy] = [event.clientX - last.clientX, event.clientY - last.clientY];
    this.#pointers.set(event.pointerId, event);
    const inDepth = event.pointerId !== this.#first || event.buttons & rightButton;
    if (event.ctrlKey || event.metaKey) this.#turnBy(dx, dy);
    else if (inDepth) this.moveBy(0, 0, -dy);
    else this.moveBy(dx, -dy, 0);
  }

  #up(event) {
    if (!this.#pointers.delete(event.pointerId)) return;
    event.stopImmediatePropagation();
    if (event.pointerId !== this.#first) return;
    this.hold.end('pointer');
  }

  #wheel(event) {
    if (!this.hold.holds('pointer') && !this.hold.holds('keys')) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.moveBy(0, 0, -event.deltaY * wheelShare);
  }

  // Rotates the tool about the axes of the screen, like a trackball.
  #turnBy(right, down) {
    const axes = this.view.axesOfCamera;
    const about = (axis, pixels) => new Quaternion().setFromAxisAngle(axis, turnPerPixel * pixels);
    this.hold.orientation.premultiply(about(axes.up, right)).premultiply(about(axes.right, down));
  }

  /// Moves the hand right, up and away from the camera. Unit: [px] at the depth of the hand.
  moveBy(right, up, away) {
    const axes = this.view.axesOfCamera;
    const pixel = this.view.pixelAt(this.hold.hand.toArray());
    this.hold.hand.addScaledVector(axes.right, right * pixel)
      .addScaledVector(axes.up, up * pixel).addScaledVector(axes.forward, away * pixel);
  }
}
