// Brings the tool to a visible point of the surface: through free space to the line of sight, then along it.

import { Vector3 } from 'three';

import { reachOf } from './tool_shape.js';

const pressed = 0.15; // depth below the surface at the end, so that it is felt. In tool sizes.
const clearance = 2.5; // distance from the surface at which the last leg begins. In tool sizes.
const lifted = 6; // distance to lift towards the camera if the straight path is not free. In tool sizes.
// Speed in tool sizes per second, and largest time step of a frame, so that a stalled page does not leap. Unit: [s].
const pace = { free: { speed: 12, longest: 1 }, last: { speed: 3, longest: 0.25 } };

export class Approach {
  #legs = []; // {to, speed, longest}
  #last = 0;

  constructor({ hold, splats, felt }) {
    Object.assign(this, { hold, splats, felt });
    hold.onChange(() => { if (hold.holds('approach') && hold.isShared) this.cancel(); });
  }

  get isOn() {
    return this.hold.holds('approach');
  }

  /// Starts towards `point`, seen along `direction`, both in the world. False if the tool's position is unknown.
  to(point, direction) {
    this.cancel();
    if (!this.hold.begin('approach')) return false;
    const back = direction.clone().normalize().negate();
    const reach = reachOf(this.felt.parts, this.hold.orientation, direction);
    const end = point.clone().addScaledVector(back, reach - pressed * this.felt.size);
    const before = end.clone().addScaledVector(back, clearance * this.felt.size);
    const way = this.#way(this.hold.hand.clone(), before, back);
    this.#legs = [...way.map((to) => ({ to, ...pace.free })), { to: end, ...pace.last }];
    return true;
  }

  cancel() {
    this.#legs = [];
    this.hold.end('approach');
  }

  // Waypoints: straight; or first towards the camera, from where the visible point is free; or around the scene.
  #way(from, to, back) {
    if (this.#isFree(from, to)) return [to];
    const nearer = Math.max(0, to.clone().sub(from).dot(back)) + lifted * this.felt.size;
    const raised = from.clone().addScaledVector(back, nearer);
    if (this.#isFree(from, raised) && this.#isFree(raised, to)) return [raised, to];
    return [...this.#around(from, to), to];
  }

  #isFree(from, to) {
    const way = to.clone().sub(from);
    const length = way.length();
    if (length === 0) return true;
    const seen = this.splats.look({ origin: from, direction: way.divideScalar(length) });
    return seen === null || seen.point.distanceTo(from) > length + this.felt.size;
  }

  // Waypoints out of the scene and around it.
  #around(from, to) {
    const box = this.splats.box;
    const middle = box.getCenter(new Vector3());
    const radius = 0.5 * box.getSize(new Vector3()).length() + 2 * this.felt.size;
    const out = (p) => p.clone().sub(middle).normalize();
    const [a, b] = [out(from), out(to)];
    const between = [0.25, 0.5, 0.75].map((share) => a.clone().lerp(b, share));
    const turned = between.map((p) => (p.lengthSq() > 0.01 ? p.normalize() : new Vector3(0, 0, 1)));
    const far = 1.3; // so that the chords between the waypoints stay outside
    return [a, ...turned, b].map((p) => p.multiplyScalar(far * radius).add(middle));
  }

  /// Call before every frame, and before the hand is published.
  update(now) {
    const seconds = now - this.#last;
    this.#last = now;
    if (!this.isOn) return;
    if (this.#legs.length === 0) {
      this.hold.end('approach');
      return;
    }
    const [{ to, speed, longest }] = this.#legs;
    const way = to.clone().sub(this.hold.hand);
    const step = speed * this.felt.size * Math.min(seconds, longest);
    if (way.length() > step) {
      this.hold.hand.addScaledVector(way.normalize(), step);
      return;
    }
    this.hold.hand.copy(to);
    this.#legs.shift();
  }
}
