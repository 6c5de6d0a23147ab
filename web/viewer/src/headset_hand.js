// A hand in a headset: its input source, where it is, and what it has pressed.

import { Quaternion, Vector3 } from 'three';

const pointingReach = 0.4; // where a screen's touch holds the tool: this far ahead. Unit: [m].
const holdingTip = 'index-finger-tip';
const stickOn = 0.7; // beyond, a stick means something; it must come back below stickOff before the next
const stickOff = 0.3;

export class HeadsetHand {
  source = null;
  controller = null; // as it is drawn
  squeezing = null; // the point of the world that it holds
  #pressed = new Set();
  #stickUsed = false;

  constructor(ray, grip, joints) {
    Object.assign(this, { ray, grip, joints });
  }

  get gamepad() {
    return this.source?.gamepad ?? null;
  }

  get isTracked() {
    return Boolean(this.source?.hand);
  }

  /// What moves and turns with it: of a tracked hand three.js follows the joints, not the grip. Null before it knows them.
  get anchor() {
    return this.isTracked ? this.joints.joints.wrist ?? null : this.grip;
  }

  /// Where it is, in WebXR's space. A tracked hand holds with the tip of a finger; a finger on a screen has no grip: it holds
  /// what it points at.
  get pose() {
    const held = Boolean(this.source?.gripSpace) || this.isTracked;
    const from = (held && this.anchor) || this.ray;
    const position = new Vector3();
    const orientation = new Quaternion();
    from.updateWorldMatrix(true, false);
    from.matrixWorld.decompose(position, orientation, new Vector3());
    if (!held) position.add(new Vector3(0, 0, -pointingReach).applyQuaternion(orientation));
    if (this.isTracked) this.joints.joints[holdingTip]?.getWorldPosition(position);
    return { position, orientation };
  }

  /// Where it points from, and the direction, in WebXR's space.
  get pointing() {
    this.ray.updateWorldMatrix(true, false);
    const origin = new Vector3().setFromMatrixPosition(this.ray.matrixWorld);
    return { origin, direction: new Vector3(0, 0, -1).transformDirection(this.ray.matrixWorld) };
  }

  /// Whether a button has been pressed since the last call.
  pressedNow(index) {
    const [is, was] = [Boolean(this.gamepad?.buttons[index]?.pressed), this.#pressed.has(index)];
    if (is) this.#pressed.add(index);
    else this.#pressed.delete(index);
    return is && !was;
  }

  /// {turn: -1, 0 or 1, once per push to the side; ahead: while it is pushed ahead}.
  readStick() {
    const [aside, along] = [this.gamepad?.axes[2] ?? 0, this.gamepad?.axes[3] ?? 0];
    const ahead = along < -stickOn && Math.abs(aside) < stickOn;
    const turn = Math.abs(aside) > stickOn && !this.#stickUsed ? Math.sign(aside) : 0;
    if (turn !== 0) this.#stickUsed = true;
    else if (Math.abs(aside) < stickOff) this.#stickUsed = false;
    return { turn, ahead };
  }
}
