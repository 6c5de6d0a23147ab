// An arrow with a shaft of constant thickness.

import { ConeGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, Vector3 } from 'three';

import { fill, setVisible } from './fill.js';

const up = new Vector3(0, 1, 0); // axis of cylinders in three.js
const headShare = 0.35; // largest length of the head, as a fraction of the arrow
const shaft = new CylinderGeometry(0.5, 0.5, 1, 16).translate(0, 0.5, 0);
const head = new ConeGeometry(1, 1, 20).translate(0, 0.5, 0);

export class Arrow extends Group {
  #pointed = new Float32Array(7);

  constructor(colorName, order) {
    super();
    const material = new MeshBasicMaterial({ transparent: true, depthTest: false });
    material.userData.color = colorName;
    this.shaft = new Mesh(shaft, material);
    this.head = new Mesh(head, material);
    this.add(this.shaft, this.head);
    for (const part of this.children) part.renderOrder = order;
    this.visible = false;
  }

  /// Draws the arrow from `origin` along `vector`, both [x, y, z]; hides it if the vector is shorter than `least`.
  /// Returns whether anything changed.
  point(origin, vector, thickness, least) {
    const along = new Vector3(...vector);
    const length = along.length();
    const toggled = setVisible(this, length > least);
    if (!this.visible) return toggled;
    const moved = fill(this.#pointed, 0, [...origin, ...vector, thickness]);
    this.position.set(...origin);
    this.quaternion.setFromUnitVectors(up, along.divideScalar(length));
    const headLength = Math.min(4 * thickness, headShare * length);
    this.shaft.scale.set(thickness, length - headLength, thickness);
    this.head.scale.set(1.5 * thickness, headLength, 1.5 * thickness);
    this.head.position.y = length - headLength;
    return toggled || moved;
  }

  /// Direction of the arrow; null while it is hidden.
  get direction() {
    return this.visible ? up.clone().applyQuaternion(this.quaternion).toArray() : null;
  }
}
