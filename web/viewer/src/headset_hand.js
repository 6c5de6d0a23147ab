// A hand in a headset: its input source, pose and buttons.

import { Quaternion, Vector3 } from 'three';

const pointingReach = 0.4; // distance of the tool ahead of a touch on a screen. Unit: [m].
const holdingTip = 'index-finger-tip';
const stickOn = 0.7; // deflection that triggers; it must return below stickOff before the next trigger
const stickOff = 0.3;

export class HeadsetHand {
  source = null;
  controller = null; // drawn object, if any
  squeezing = null; // grabbed point of the world, or null
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

  /// Object that follows the hand: for a tracked hand the wrist joint, null until three.js has it; else the grip.
  get anchor() {
    return this.isTracked ? this.joints.joints.wrist ?? null : this.grip;
  }

  /// Pose in WebXR's space. A tracked hand holds the tool with the tip of a finger; a touch on a screen has no grip and
  /// holds it at a distance along its ray.
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

  /// Origin and direction of its pointing ray, in WebXR's space.
  get pointing() {
    this.ray.updateWorldMatrix(true, false);
    const origin = new Vector3().setFromMatrixPosition(this.ray.matrixWorld);
    return { origin, direction: new Vector3(0, 0, -1).transformDirection(this.ray.matrixWorld) };
  }

  /// Returns whether a button has been pressed since the last call.
  pressedNow(index) {
    const [is, was] = [Boolean(this.gamepad?.buttons[index]?.pressed), this.#pressed.has(index)];
    if (is) this.#pressed.add(index);
    else this.#pressed.delete(index);
    return is && !was;
  }

  /// Returns {turn, ahead}: `turn` is -1 or 1 once per sideways push, else 0; `ahead` is true while pushed forward.
  readStick() {
    const [aside, along] = [this.gamepad?.axes[2] ?? 0, this.gamepad?.axes[3] ?? 0];
    const ahead = along < -stickOn && Math.abs(aside) < stickOn;
    const turn = Math.abs(aside) > stickOn && !this.#stickUsed ? Math.sign(aside) : 0;
    if (turn !== 0) this.#stickUsed = true;
    else if (Math.abs(aside) < stickOff) this.#stickUsed = false;
    return { turn, ahead };
  }
}
