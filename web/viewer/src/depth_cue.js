// Depth cue of the tool: a line to the nearest point of the surface with a ring there, or, in contact, a ring around
// the deepest contact.

import { BufferAttribute, BufferGeometry, Group, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, RingGeometry, Vector3 } from 'three';

import { fill, setVisible } from './fill.js';
import { reachOf } from './tool_shape.js';

const searchEvery = 60; // interval of searches for the nearest point. Unit: [ms].
const farthest = 40; // largest gap for which a line is drawn. In tool sizes.
const touching = 0.02; // smallest gap for which a line is drawn. In tool sizes.
const order = 3;
const forward = new Vector3(0, 0, 1);

export class DepthCue {
  group = new Group();
  gap = null; // {length, from, to} in the world, or null
  #searchedAt = -Infinity;
  #found = null;

  constructor(splats, felt) {
    Object.assign(this, { splats, felt });
    this.line = new Line(new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(6), 3)), material(LineBasicMaterial, '--tool'));
    this.ring = new Mesh(new RingGeometry(0.75, 1, 40), material(MeshBasicMaterial, '--tool', { side: 2, opacity: 0.85 }));
    this.contact = new Mesh(new RingGeometry(0.8, 1.15, 40), material(MeshBasicMaterial, '--force', { side: 2, opacity: 0.9 }));
    this.line.frustumCulled = false;
    for (const part of [this.line, this.ring, this.contact]) part.renderOrder = order;
    this.group.add(this.line, this.ring, this.contact);
    this.#hide();
  }

  #hide() {
    return [this.line, this.ring, this.contact].map((part) => setVisible(part, false)).includes(true);
  }

  /// Call before every frame. Returns whether anything changed.
  update(live, now) {
    this.gap = null;
    if (!live.isFresh('measured_cp')) return this.#hide();
    const deepest = this.#deepest(live);
    if (deepest) return this.#showContact(deepest);
    const gap = this.#measure(live.tool, now);
    const off = setVisible(this.contact, false);
    const toggled = [this.line, this.ring].map((part) => setVisible(part, gap !== null)).includes(true) || off;
    return gap ? this.#showGap(gap) || toggled : toggled;
  }

  #deepest(live) {
    if (!live.isFresh('contacts')) return null;
    return live.contacts.reduce((best, c) => (c.normal && c.depth > (best?.depth ?? 0) ? c : best), null);
  }

  #showContact({ normal: { from, to } }) {
    const toggled = [setVisible(this.contact, true), setVisible(this.line, false), setVisible(this.ring, false)];
    const along = new Vector3(...to).sub(new Vector3(...from)).normalize();
    return this.#lay(this.contact, new Vector3(...from), along, 0.5) || toggled.includes(true);
  }

  #measure(tool, now) {
    if (now - this.#searchedAt > searchEvery) {
      this.#searchedAt = now;
      this.#found = this.splats.closest(tool.position);
    }
    if (!this.#found) return null;
    const at = new Vector3(...tool.position);
    const way = this.#found.point.clone().sub(at);
    const { size, parts } = this.felt;
    const handle = this.felt.turnOf(tool);
    const reach = reachOf(parts, handle, way);
    const length = way.length() - reach;
    if (length > farthest * size || length < touching * size) return null;
    this.gap = { length, from: at.addScaledVector(way.normalize(), reach), to: this.#found.point };
    return this.gap;
  }

  #showGap({ from, to }) {
    const { position } = this.line.geometry.attributes;
    const moved = fill(position.array, 0, [...from.toArray(), ...to.toArray()]);
    if (moved) position.needsUpdate = true;
    return this.#lay(this.ring, to, from.clone().sub(to).normalize(), 0.35) || moved;
  }

  #lay(ring, at, normal, sizes) {
    const before = ring.matrix.clone();
    ring.position.copy(at);
    ring.quaternion.setFromUnitVectors(forward, normal);
    ring.scale.setScalar(sizes * this.felt.size);
    ring.updateMatrix();
    return !before.equals(ring.matrix);
  }
}

function material(Kind, color, options = {}) {
  const made = new Kind({ transparent: true, depthTest: false, ...options });
  made.userData.color = color;
  return made;
}
