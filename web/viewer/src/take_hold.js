// The first things that a person does at a desk: find the tool, look at the object, bring the tool to where they click.

import { Vector3 } from 'three';

import { byId } from '../../shared/dom.js';
import { formatCount } from '../../shared/format.js';
import { followClicks } from './clicks.js';
import { Covered } from './covered.js';
import { formatLength } from './format.js';
import { notify } from './notices.js';
import { Overlay } from './overlay.js';
import { boxAround } from './view.js';

const findShare = 0.12; // of the height of the view, that the tool fills once it is looked for
const focusShare = 0.5; // of the way to what is double-clicked, that is left
const mostTimes = 300; // that a scene is larger than the tool, where its unit is probably not the metre
const patience = 1000; // with a program that has not said where the tool is. Unit: [ms].
const leastForce = 0.05; // from which on a person has felt something. Unit: [N].
const nearest = 8; // a double click goes no nearer. In sizes of the tool.
const toolRoom = 1.2; // around the middle of the tool, that is kept in view. In sizes of the tool.
const mostBehind = 5; // what is cut off, that is clicked through. In sizes of the tool.
const solid = 0.8; // opacity along a ray from which on it is no haze
const [ringCount, ringPoints] = [8, 8]; // around the middle, where a key looks for something to feel
const mostCovered = { top: 0.2, bottom: 0.15 }; // of the height, that is kept free: on a small page things are seen behind the rest

// Points on rings about the middle, nearest first: [x, y] in pixels.
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

  /// To be called once a scene is there.
  open() {
    this.frameAll();
    if (this.parameters.current.registration.assumed?.includes('scale')) return; // it gets a size
    const times = this.splats.box.getSize(new Vector3()).length() / this.felt.size;
    if (times > mostTimes) notify(`The tool is ${formatCount(Number(times.toPrecision(2)))} times smaller than the scene. “Propose a setup” in Placement finds a scale.`, 'message');
  }

  /// The whole object in the middle, and the tool if it is near.
  frameAll() {
    const { live, felt, splats, view } = this;
    view.frameAll(splats.box, this.covered.rows(mostCovered), live.tool ? boxAround([live.tool.position], toolRoom * felt.size) : undefined);
  }

  findTool() {
    const { live, view, felt } = this;
    if (!live.isFresh('measured_cp')) notify('It is not known where the tool is.');
    else view.focus(new Vector3(...live.tool.position), view.distanceFor(felt.size, findShare));
  }

  toggleKeys() {
    const { hold } = this;
    if (hold.holds('keys')) hold.end('keys');
    else if (!hold.begin('keys')) notify('The tool can be held as soon as the program says where it is.');
  }

  /// Brings the tool to what can be felt in the middle of the view, or nearest to it: to haze only where there is nothing else.
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
    if (!seen && told) notify('There is nothing to feel near the middle of the view.');
    if (this.picker.waits && seen?.felt) this.picker.give(seen.point);
    else if (this.picker.waits) notify('There is nothing to feel at that point.');
    else if (seen) this.#touch(seen, ray);
  }

  #touch(seen, ray) {
    if (this.parameters.current?.demo === undefined || this.view.renderer.xr.isPresenting) return; // a device has a hand of its own
    const there = seen.felt ? seen : this.splats.lookForFelt(ray);
    if (there && there.point.distanceTo(seen.point) < mostBehind * this.felt.size) this.#approach(there.point, ray.direction);
    else notify('What is seen there is cut off by the filter: it cannot be felt.');
  }

  // A page that has just taken long to draw has not heard meanwhile where the tool is.
  async #approach(point, direction) {
    if (!this.live.isFresh('measured_cp')) await this.live.next('measured_cp', patience);
    if (!this.approach.to(point, direction)) notify('The tool can be moved as soon as the program says where it is.');
  }

  #focus(ray) {
    const seen = this.splats.look(ray);
    if (!seen || this.picker.waits) return;
    this.approach.cancel();
    const { view, felt } = this;
    const distance = focusShare * view.camera.position.distanceTo(seen.point);
    view.focus(seen.point, Math.max(distance, nearest * felt.size));
  }

  /// To be called before every frame.
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
