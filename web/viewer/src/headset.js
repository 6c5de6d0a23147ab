// WebXR: the scene in a headset or in the camera's picture, and the tool in a controller.
//
// Trigger: the tool is at the controller's grip while it is pressed. Squeeze: grabs the world; with both hands it
// turns and scales, too. Stick to the side: turns by 30 degrees. A or X: emergency stop, and again to resume. B or
// Y: leave.

import { Quaternion, Vector3 } from 'three';

import { play } from './haptics.js';
import { Sign } from './sign.js';

const snap = Math.PI / 6;
const stickOn = 0.7; // beyond, a stick means a turn; it must come back below stickOff before the next
const stickOff = 0.3;
const button = { stop: 4, leave: 5 }; // of the mapping xr-standard
const pointingReach = 0.4; // where a screen's touch holds the tool: this far ahead. Unit: [m].

export const sessionModes = ['immersive-vr', 'immersive-ar'];

export async function supportedModes() {
  if (!navigator.xr) return [];
  const supported = await Promise.all(sessionModes.map((mode) => navigator.xr.isSessionSupported(mode).catch(() => false)));
  return sessionModes.filter((_, i) => supported[i]);
}

export class Headset {
  session = null;
  #hands = [0, 1].map(() => ({ squeezing: null, pressed: new Set(), turned: false, source: null }));
  #holding = null; // the hand with the tool

  constructor({ view, room, hold, splats, actions, signText }) {
    Object.assign(this, { view, room, hold, splats, actions, signText });
    const { xr } = view.renderer;
    xr.enabled = true;
    xr.setReferenceSpaceType('local-floor');
    xr.addEventListener('sessionend', () => this.#left());
    this.sign = new Sign();
    this.#hands.forEach((hand, i) => this.#attach(hand, xr.getController(i), xr.getControllerGrip(i)));
    // A finger on a button of the page does not hold the tool as well.
    document.addEventListener('beforexrselect', (event) => {
      if (event.target.closest?.('.bar, .stop, .panels, .notices')) event.preventDefault();
    });
  }

  #attach(hand, ray, grip) {
    Object.assign(hand, { ray, grip });
    this.view.add(ray, grip);
    ray.addEventListener('connected', ({ data }) => {
      hand.source = data;
      if (data.handedness === 'left') grip.add(this.sign.mesh);
    });
    ray.addEventListener('disconnected', () => {
      this.#letGo(hand);
      hand.squeezing = null;
      hand.source = null;
    });
    ray.addEventListener('selectstart', () => this.#take(hand));
    ray.addEventListener('selectend', () => this.#letGo(hand));
    ray.addEventListener('squeezestart', () => this.#grab(hand, true));
    ray.addEventListener('squeezeend', () => this.#grab(hand, false));
  }

  async enter(mode, overlay) {
    const optionalFeatures = ['hand-tracking', 'dom-overlay'];
    const session = await navigator.xr.requestSession(mode, {
      requiredFeatures: ['local-floor'], optionalFeatures, domOverlay: { root: overlay },
    });
    this.session = session;
    session.addEventListener('visibilitychange', () => { if (session.visibilityState !== 'visible') this.#letGoAll(); });
    if (this.room.isIdentity) this.room.placeFirst(this.splats.box);
    this.view.enterHeadset(mode === 'immersive-vr');
    try {
      await this.view.renderer.xr.setSession(session);
    } catch (error) {
      await session.end(); // nobody would see anything in it
      throw error;
    }
    this.view.renderer.xr.setFoveation(1);
    this.#placeWorld();
    await this.splats.enterHeadset();
  }

  leave() {
    return this.session?.end();
  }

  #left() {
    this.session = null;
    this.#letGoAll();
    this.sign.mesh.removeFromParent();
    this.view.world.position.set(0, 0, 0);
    this.view.world.quaternion.identity();
    this.view.world.scale.set(1, 1, 1);
    this.view.leaveHeadset();
    this.splats.leaveHeadset();
  }

  #letGoAll() {
    for (const hand of this.#hands) {
      this.#letGo(hand);
      hand.squeezing = null;
    }
  }

  #placeWorld() {
    const { world } = this.view;
    this.room.xrFromWorld.decompose(world.position, world.quaternion, world.scale);
  }

  #take(hand) {
    if (this.#holding && this.#holding !== hand) return;
    if (this.hold.begin('headset')) this.#holding = hand;
  }

  #letGo(hand) {
    if (this.#holding !== hand) return;
    this.#holding = null;
    this.hold.end('headset');
  }

  #grab(hand, on) {
    hand.squeezing = on ? this.room.toWorld(poseOf(hand).position) : null;
    // What the others hold begins anew, too: two hands mean another thing than one.
    for (const other of this.#hands) if (other.squeezing) other.squeezing = this.room.toWorld(poseOf(other).position);
    if (!on) this.actions.setRoom(this.room.json);
  }

  /// To be called before every frame.
  update() {
    if (!this.session) return;
    for (const hand of this.#hands) this.#readButtons(hand);
    const grabbing = this.#hands.filter((hand) => hand.squeezing);
    if (grabbing.length > 0) {
      this.room.grab(grabbing.map((h) => h.squeezing), grabbing.map((h) => poseOf(h).position));
    }
    this.#placeWorld();
    this.sign.show(this.signText());
    if (!this.#holding) return;
    const pose = poseOf(this.#holding);
    this.hold.hand.copy(this.room.toWorld(pose.position));
    this.hold.orientation.copy(this.room.turnToWorld(pose.orientation));
  }

  /// Plays a pulse in the hand that holds the tool.
  pulse(pulse) {
    const gamepad = this.#holding?.source?.gamepad;
    if (gamepad) play(gamepad, pulse);
  }

  #readButtons(hand) {
    const gamepad = hand.source?.gamepad;
    if (!gamepad) return;
    if (pressedNow(hand, gamepad, button.stop)) this.actions.stopOrResume();
    if (pressedNow(hand, gamepad, button.leave)) this.leave();
    const aside = gamepad.axes[2] ?? 0;
    if (Math.abs(aside) > stickOn && !hand.turned) {
      this.room.turn(-Math.sign(aside) * snap, this.view.camera.position);
      this.actions.setRoom(this.room.json);
    }
    if (Math.abs(aside) > stickOn) hand.turned = true;
    else if (Math.abs(aside) < stickOff) hand.turned = false;
  }
}

function pressedNow(hand, gamepad, index) {
  const [is, was] = [Boolean(gamepad.buttons[index]?.pressed), hand.pressed.has(index)];
  if (is) hand.pressed.add(index);
  else hand.pressed.delete(index);
  return is && !was;
}

// Where a hand is, in WebXR's space. A finger on a screen has no grip: it holds what it points at.
function poseOf({ source, grip, ray }) {
  const from = source?.gripSpace ? grip : ray;
  const position = new Vector3();
  const orientation = new Quaternion();
  from.updateWorldMatrix(true, false);
  from.matrixWorld.decompose(position, orientation, new Vector3());
  if (!source?.gripSpace) position.add(new Vector3(0, 0, -pointingReach).applyQuaternion(orientation));
  return { position, orientation };
}
