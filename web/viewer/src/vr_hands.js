// Controllers and hands as they are seen in a headset.

import {
  BufferGeometry, CapsuleGeometry, Group, Line, LineBasicMaterial, Mesh, MeshLambertMaterial, SphereGeometry, TorusGeometry, Vector3,
} from 'three';

import { themeValue } from '../../shared/theme.js';

const rayLength = 1.5; // Unit: [m].
const slimmer = 0.7; // than the radius of a joint, so that fingers can be told apart
const usualJoint = 0.008; // radius of a joint that says none. Unit: [m].

function solid(geometry, color) {
  return new Mesh(geometry, new MeshLambertMaterial({ color: themeValue(color), transparent: true }));
}

/// A handle with a ring, along the axes of the grip.
export function drawnController() {
  const group = new Group();
  const handle = solid(new CapsuleGeometry(0.016, 0.075, 6, 14), '--ink');
  handle.position.set(0, -0.015, 0.03);
  handle.rotation.x = Math.PI / 3;
  const ring = solid(new TorusGeometry(0.034, 0.005, 8, 28), '--tool');
  ring.position.set(0, 0.012, -0.02);
  ring.rotation.x = Math.PI / 3;
  group.add(handle, ring);
  for (const part of group.children) part.renderOrder = 12;
  return group;
}

export function drawnRay() {
  const geometry = new BufferGeometry().setFromPoints([new Vector3(0, 0, -0.03), new Vector3(0, 0, -rayLength)]);
  const line = new Line(geometry, new LineBasicMaterial({ color: themeValue('--tool'), transparent: true, opacity: 0.6, depthTest: false }));
  line.renderOrder = 12;
  return line;
}

/// Gives the joints of a tracked hand, as three.js has them, a ball each. Called before every frame: joints come one by one.
export function drawHand(hand) {
  for (const joint of Object.values(hand.joints)) {
    if (joint.children.length === 0) joint.add(Object.assign(solid(new SphereGeometry(1, 12, 8), '--tool'), { renderOrder: 12 }));
    joint.children[0].scale.setScalar(slimmer * (joint.jointRadius || usualJoint));
  }
}
