// First steps of a user: find the tool, frame the object, bring the tool to a clicked point.

import { Vector3 } from 'three';

import { byId } from '../../shared/dom.js';
import { formatCount } from '../../shared/format.js';
import { followClicks } from './clicks.js';
import { Covered } from './covered.js';
import { formatLength } from './format.js';
import { notify } from './notices.js';
import { Overlay } from './overlay.js';
import { boxAround } from './view.js';

const findShare = 0.12; // fraction of the view's height that the tool fills after "Find tool"
const focusShare = 0.5; // factor on the distance to a double-clicked point
const mostTimes = 300; // ratio of scene and tool size above which the scene's unit is probably not the metre
const patience = 1000; // longest wait for the tool's position. Unit: [ms].
const leastForce = 0.05; // force above which a user has felt something. Unit: [N].
const nearest = 8; // least distance after a double click. In tool sizes.
const toolRoom = 1.2; // margin around the tool's centre that is kept in view. In tool sizes.
const mostBehind = 5; // largest thickness of filtered splats that a click passes through. In tool sizes.
const solid = 0.8; // opacity along a ray above which it is not haze
const [ringCount, ringPoints] = [8, 8]; // rings of points around the middle that touchMiddle() examines
const mostCovered = { top: 0.2, bottom: 0.15 }; // largest fraction of the height that is left free for controls

// Points [x, y] on rings around the middle, nearest first. Unit: [px].
function rings(farthest) {
  const points = [[0, 0]];
  for (let k = 1; k <= ringCount; k += 1) {
    for (let i = 0; i < ringPoints; i += 1) {
      const [r, angle] = [(farthest * k) / ringCount, (2 * Math.PI * (i + 0.5 * (k % 2))) / ringPoints];
      points.push([r * Math.cos(angle), r * Math.sin(angle)]);
    }
  }
  return points;
}

export class TakeHold {
  constructor({ view, splats, felt, live, hold, picker, approach, depth, parameters }) {
    Object.assign(this, { view, splats, felt, live, hold, picker, approach, depth, parameters });
    this.overlay = new Overlay(view);
    this.covered = new Covered(view.canvas);
    followClicks(view.canvas, (event) => this.#click(view.rayAt(event)));
    view.canvas.addEventListener('dblclick', (event) => this.#focus(view.rayAt(event)));
    byId('frame-all').addEventListener('click', () => this.frameAll());
    byId('find').addEventListener('click', () => this.findTool());
    byId('hint-close').addEventListener('click', () => { byId('hint').hidden = true; });
  }

  get shortcuts() {
    return { f: () => this.frameAll(), t: () => this.findTool(), h: () => this.toggleKeys(), c: () => this.touchMiddle() };
  }

  /// Call once a scene is loaded.
  open() {
    this.frameAll();
    if (this.parameters.current.registration.assumed?.includes('scale')) return; // FirstSize sets the scale
    const times = this.splats.box.getSize(new Vector3()).length() / this.felt.size;
    if (times > mostTimes) notify(`The tool is ${formatCount(Number(times.toPrecision(2)))} times smaller than the scene. “Propose a setup” in Placement finds a scale.`, 'message');
  }

  /// Frames the whole object, and the tool if it is near.
  frameAll() {
    const { live, felt, splats, view } = this;
    view.frameAll(splats.box, this.covered.rows(mostCovered), live.tool ? boxAround([live.tool.position], toolRoom * felt.size) : undefined);
  }

  findTool() {
    const { live, view, felt } = this;
    if (!live.isFresh('measured_cp')) notify('The position of the tool is unknown.');
    else view.focus(new Vector3(...live.tool.position), view.distanceFor(felt.size, findShare));
  }

  toggleKeys() {
    const { hold } = this;
    if (hold.holds('keys')) hold.end('keys');
    else if (!hold.begin('keys')) notify('The tool cannot be held yet: its position is unknown.');
  }

  /// Brings the tool to the surface that can be felt at or nearest to the middle of the view; to haze only if there is
  /// no other.
  touchMiddle() {
    const { left, top, width, height } = this.view.canvas.getBoundingClientRect();
    const rayAt = ([x, y]) => this.view.rayAt({ clientX: left + 0.5 * width + x, clientY: top + 0.5 * height + y });
    let found = null;
    for (const off of rings(0.45 * Math.min(width, height))) {
      const seen = this.splats.look(rayAt(off));
      if (!seen?.felt) continue;
      found ??= off;
      if (seen.opacity < solid) continue;
      found = off;
      break;
    }
    this.#click(rayAt(found ?? [0, 0]), !found);
  }

  #click(ray, told = false) {
    const seen = this.splats.look(ray);
    if (!seen && told) notify('No touchable surface near the centre of the view.');
    if (this.picker.waits && seen?.felt) this.picker.give(seen.point);
    else if (this.picker.waits) notify('No touchable surface at this point.');
    else if (seen) this.#touch(seen, ray);
  }

  #touch(seen, ray) {
    if (this.parameters.current?.demo === undefined || this.view.renderer.xr.isPresenting) return; // a real device
    const there = seen.felt ? seen : this.splats.lookForFelt(ray);
    if (there && there.point.distanceTo(seen.point) < mostBehind * this.felt.size) this.#approach(there.point, ray.direction);
    else notify('The filter removes the Gaussians at this point: they exert no force.');
  }

  // After a long frame, the tool's position may be stale: waits for the next message.
  async #approach(point, direction) {
    if (!this.live.isFresh('measured_cp')) await this.live.next('measured_cp', patience);
    if (!this.approach.to(point, direction)) notify('The tool cannot be moved yet: its position is unknown.');
  }

  #focus(ray) {
    const seen = this.splats.look(ray);
    if (!seen || this.picker.waits) return;
    this.approach.cancel();
    const { view, felt } = this;
    const distance = focusShare * view.camera.position.distanceTo(seen.point);
    view.focus(seen.point, Math.max(distance, nearest * felt.size));
  }

  /// Call before every frame.
  update() {
    this.overlay.show(this.#seenTool());
    if (this.#isFeltByHand) byId('hint').hidden = true;
  }

  get #isFeltByHand() {
    return this.parameters.current?.demo === false && Math.hypot(...(this.live.force ?? [0])) > leastForce;
  }

  #seenTool() {
    const { view, live, felt, depth } = this;
    if (!live.isFresh('measured_cp') || view.renderer.xr.isPresenting) return null;
    const { position } = live.tool;
    const middle = depth.gap && depth.gap.from.clone().lerp(depth.gap.to, 0.5).toArray();
    const at = middle && view.project(middle);
    const seen = view.project(position);
    return {
      covered: this.covered.near(seen && seen[0]), at: seen, towards: view.towards(position), radius: felt.size / view.pixelAt(position),
      distant: at && { text: formatLength(depth.gap.length), at },
    };
  }
}
