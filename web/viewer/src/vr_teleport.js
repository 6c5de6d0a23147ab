// Teleport in a headset: to the point where a ballistic arc from a hand meets the floor.

import { BufferAttribute, BufferGeometry, Group, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, RingGeometry, Vector3 } from 'three';

import { themeValue } from '../../shared/theme.js';

const speed = 5; // initial speed of the arc. Unit: [m/s].
const gravity = new Vector3(0, -9.81, 0);
const points = 24; // number of points of the drawn arc

/// Landing point on the floor, in WebXR's space, and flight time: {target, time}.
export function landing(origin, direction) {
  const v = direction.clone().normalize().multiplyScalar(speed);
  const height = Math.max(origin.y, 0);
  const time = (v.y + Math.sqrt(v.y * v.y - 2 * gravity.y * height)) / -gravity.y;
  return { target: origin.clone().addScaledVector(v, time).setY(0), time };
}

export class Teleport {
  group = new Group();
  target = null;

  constructor() {
    const look = { color: themeValue('--tool'), transparent: true, depthTest: false };
    this.arc = new Line(new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(3 * points), 3)), new LineBasicMaterial(look));
    this.spot = new Mesh(new RingGeometry(0.16, 0.22, 40).rotateX(-Math.PI / 2), new MeshBasicMaterial(look));
    this.arc.frustumCulled = false;
    this.group.add(this.arc, this.spot);
    for (const part of this.group.children) part.renderOrder = 12;
    this.group.visible = false;
  }

  aim(origin, direction) {
    const { target, time } = landing(origin, direction);
    const v = direction.clone().normalize().multiplyScalar(speed);
    const { position } = this.arc.geometry.attributes;
    for (let i = 0; i < points; ++i) {
      const t = (time * i) / (points - 1);
      const at = origin.clone().addScaledVector(v, t).addScaledVector(gravity, 0.5 * t * t);
      position.setXYZ(i, at.x, at.y, at.z);
    }
    position.needsUpdate = true;
    this.spot.position.copy(target);
    this.target = target;
    this.group.visible = true;
  }

  /// Ends aiming. Returns the target, or null.
  end() {
    const { target } = this;
    this.target = null;
    this.group.visible = false;
    return target;
  }
}
