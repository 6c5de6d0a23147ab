// Transform between the physical room of a headset and the world.
//
// The program keeps `room` as {scale, rotation, translation}: world = scale * rotation * p + translation, where p
// is a point of the room in metres with x to the right, y forward and z up from the floor. WebXR has y up and z
// backward; `upright` converts between the two.

import { Matrix4, Quaternion, Vector3 } from 'three';

const upright = new Matrix4().makeBasis(new Vector3(1, 0, 0), new Vector3(0, 0, 1), new Vector3(0, -1, 0));
const uprightTurn = new Quaternion().setFromRotationMatrix(upright);
const z = new Vector3(0, 0, 1);
const smallest = 0.01;
const largest = 100;
const aheadOfHands = new Vector3(0, 0.5, 1.1); // initial place of a small scene. Unit: [m] in the room.
const handheld = 1.5; // diagonal below which a scene is placed there; larger ones are walked in. Unit: [m].

export class Room {
  scale = 1;
  rotation = new Quaternion();
  translation = new Vector3();

  set({ scale, rotation: [w, x, y, zz], translation }) {
    this.scale = scale;
    this.rotation.set(x, y, zz, w);
    this.translation.set(...translation);
  }

  get json() {
    const { x, y, z: zz, w } = this.rotation;
    return { scale: this.scale, rotation: [w, x, y, zz], translation: this.translation.toArray() };
  }

  get isIdentity() {
    return this.scale === 1 && this.translation.lengthSq() === 0 && Math.abs(this.rotation.w) === 1;
  }

  /// Transform from WebXR's space to the world.
  get worldFromXr() {
    return new Matrix4().compose(this.translation, this.rotation, new Vector3().setScalar(this.scale)).multiply(upright);
  }

  /// Transform from the world to WebXR's space.
  get xrFromWorld() {
    return this.worldFromXr.invert();
  }

  /// Transforms a point of WebXR's space to the world.
  toWorld(point) {
    return point.clone().applyMatrix4(this.worldFromXr);
  }

  /// Transforms an orientation in WebXR's space to the world.
  turnToWorld(orientation) {
    return this.rotation.clone().multiply(uprightTurn).multiply(orientation);
  }

  /// Initial placement: the centre of a small scene within reach of the hands, or the floor of a large one at the feet.
  placeFirst(box) {
    const size = box.getSize(new Vector3());
    const middle = box.getCenter(new Vector3());
    if (size.length() < handheld) this.translation.copy(middle).sub(aheadOfHands);
    else this.translation.set(middle.x, middle.y, box.min.z);
  }

  /// Changes the room so that the world points `before` are at the hands, at `now` in WebXR's space: one hand moves the
  /// world; two also rotate it about the vertical and scale it. The vertical is preserved.
  grab(before, now) {
    const inRoom = now.map((p) => p.clone().applyMatrix4(upright));
    if (now.length === 2) {
      const wanted = before[1].clone().sub(before[0]);
      const has = inRoom[1].clone().sub(inRoom[0]);
      if (has.length() > 1e-3) {
        this.scale = Math.min(Math.max(wanted.length() / has.length(), smallest), largest);
        const yaw = Math.atan2(wanted.y, wanted.x) - Math.atan2(has.y, has.x);
        if (Math.hypot(has.x, has.y) > 1e-3) this.rotation.setFromAxisAngle(z, yaw);
      }
    }
    const mean = (points) => points.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(points.length);
    const held = mean(inRoom).applyQuaternion(this.rotation).multiplyScalar(this.scale);
    this.translation.copy(mean(before)).sub(held);
  }

  /// Rotates the world by `angle` about the vertical through a point of WebXR's space.
  turn(angle, about) {
    const centre = this.toWorld(about);
    const turn = new Quaternion().setFromAxisAngle(z, angle);
    this.rotation.premultiply(turn);
    this.translation.sub(centre).applyQuaternion(turn).add(centre);
  }
}
