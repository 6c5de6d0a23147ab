// Drawing of controllers and hands in a headset.

import {
  BufferGeometry, CapsuleGeometry, CylinderGeometry, Group, Line, LineBasicMaterial, Mesh, MeshLambertMaterial, SphereGeometry, TorusGeometry, Vector3,
} from 'three';

import { themeValue } from '../../shared/theme.js';

const rayLength = 1.5; // Unit: [m].
const slimmer = 0.7; // factor on the radius of joints, to separate the fingers
const usualJoint = 0.008; // default radius of a joint. Unit: [m].
const faint = 0.25; // opacity of a controller that holds the tool, as they coincide
const order = 12;
const fingers = ['thumb', 'index-finger', 'middle-finger', 'ring-finger', 'pinky-finger'];
const bones = ['metacarpal', 'phalanx-proximal', 'phalanx-intermediate', 'phalanx-distal', 'tip']; // a thumb has no intermediate one
const up = new Vector3(0, 1, 0);

function solid(geometry, color) {
  return new Mesh(geometry, new MeshLambertMaterial({ color: themeValue(color), transparent: true }));
}

/// Controller: a handle with a ring, along the axes of the grip.
export function drawnController() {
  const group = new Group();
  const handle = solid(new CapsuleGeometry(0.016, 0.075, 6, 14), '--ink');
  handle.position.set(0, -0.015, 0.03);
  handle.rotation.x = Math.PI / 3;
  const ring = solid(new TorusGeometry(0.034, 0.005, 8, 28), '--tool');
  ring.position.set(0, 0.012, -0.02);
  ring.rotation.x = Math.PI / 3;
  group.add(handle, ring);
  for (const part of group.children) part.renderOrder = order;
  return group;
}

/// Makes an object of drawnController() translucent while it holds the tool.
export function showHolding(controller, holds) {
  for (const { material } of controller.children) material.opacity = holds ? faint : 1;
}

export function drawnRay() {
  const geometry = new BufferGeometry().setFromPoints([new Vector3(0, 0, -0.03), new Vector3(0, 0, -rayLength)]);
  const line = new Line(geometry, new LineBasicMaterial({ color: themeValue('--tool'), transparent: true, opacity: 0.6, depthTest: false }));
  line.renderOrder = order;
  return line;
}

/// Draws the three.js joints of a tracked hand as balls, with bones between them. Call before every frame: joints
/// appear one by one.
export function drawHand({ joints }) {
  for (const joint of Object.values(joints)) {
    if (joint.children.length === 0) joint.add(part(new SphereGeometry(1, 12, 8)));
    joint.children[0].scale.setScalar(radiusOf(joint));
  }
  for (const finger of fingers) {
    const chain = [joints.wrist, ...bones.map((bone) => joints[`${finger}-${bone}`])].filter(Boolean);
    chain.slice(1).forEach((joint, i) => drawBone(joint, chain[i]));
  }
}

const part = (geometry) => Object.assign(solid(geometry, '--tool'), { renderOrder: order });
const radiusOf = ({ jointRadius }) => slimmer * (jointRadius || usualJoint);

function drawBone(joint, before) {
  if (joint.children.length === 1) joint.add(part(new CylinderGeometry(1, 1, 1, 10, 1, true)));
  const [, bone] = joint.children;
  const way = before.position.clone().sub(joint.position).applyQuaternion(joint.quaternion.clone().invert());
  const length = way.length();
  const thick = Math.min(radiusOf(joint), radiusOf(before));
  bone.visible = length > 0;
  bone.scale.set(thick, length, thick);
  bone.position.copy(way).multiplyScalar(0.5);
  bone.quaternion.setFromUnitVectors(up, way.divideScalar(length || 1));
}
