// WebXR: the scene in a headset (VR) or in the camera's image (AR), with the tool in a controller or a tracked hand.
//
// Trigger or pinch: the tool follows the grip while it is pressed. Squeeze, or pinch with the other hand: grabs the
// world; both hands together rotate and scale it. Stick sideways: turns by 30 degrees; forward: teleports. A or X:
// emergency stop, which never resumes; a button on the panel at the left hand does. B or Y: leave.

import { Vector3 } from 'three';

import { FrameTimes } from './frame_times.js';
import { play } from './haptics.js';
import { HeadsetHand } from './headset_hand.js';
import { roomPanelContent, roomPanelButtons } from './room_panel_content.js';
import { drawHand, drawnController, drawnRay, showHolding } from './vr_hands.js';
import { RoomPanel } from './vr_panel.js';
import { EyeSigns } from './vr_signs.js';
import { Surroundings } from './vr_surroundings.js';
import { Teleport } from './vr_teleport.js';

const snap = Math.PI / 6;
const button = { stop: 4, leave: 5 }; // indices in the xr-standard mapping
const longestFrame = 0.1; // largest time step, after a stall. Unit: [s].

export const sessionModes = ['immersive-vr', 'immersive-ar'];

export async function supportedModes() {
  if (!navigator.xr) return [];
  const supported = await Promise.all(sessionModes.map((mode) => navigator.xr.isSessionSupported(mode).catch(() => false)));
  return sessionModes.filter((_, i) => supported[i]);
}

export class Headset {
  session = null;
  frames = new FrameTimes();
  signs = new EyeSigns();
  surroundings = new Surroundings();
  teleport = new Teleport();
  #holding = null; // hand that holds the tool
  #aiming = null; // hand that aims a teleport
  #last = 0;

  /// `parts` are {view, room, hold, splats, felt, live, actions, statusBar, parameters}.
  constructor(parts) {
    Object.assign(this, parts);
    const { xr } = this.view.renderer;
    xr.enabled = true;
    xr.setReferenceSpaceType('local-floor');
    xr.addEventListener('sessionend', () => this.#left());
    this.panel = new RoomPanel(roomPanelButtons(this));
    this.view.add(this.surroundings.group, this.teleport.group);
    this.hands = [0, 1].map((i) => new HeadsetHand(xr.getController(i), xr.getControllerGrip(i), xr.getHand(i)));
    for (const hand of this.hands) this.#attach(hand);
    // A touch on a control of the page must not take the tool as well.
    document.addEventListener('beforexrselect', (event) => {
      if (event.target.closest?.('.bar, .stop, .panels, .notices')) event.preventDefault();
    });
  }

  #attach(hand) {
    const { ray, grip, joints } = hand;
    this.view.add(ray, grip, joints);
    ray.addEventListener('connected', ({ data }) => this.#appear(hand, data));
    ray.addEventListener('disconnected', () => {
      this.#letGo(hand);
      hand.squeezing = null;
      hand.source = null;
      hand.controller = null;
      if (this.#aiming === hand) {
        this.#aiming = null;
        this.teleport.end();
      }
      for (const part of [ray, grip]) part.clear();
    });
    ray.addEventListener('selectstart', () => this.#take(hand));
    ray.addEventListener('selectend', () => this.#letGo(hand));
    ray.addEventListener('squeezestart', () => this.#grab(hand, true));
    ray.addEventListener('squeezeend', () => this.#grab(hand, false));
  }

  #appear(hand, source) {
    hand.source = source;
    if (source.targetRayMode !== 'tracked-pointer') return;
    hand.ray.add(drawnRay());
    if (source.hand) return;
    hand.controller = drawnController();
    hand.grip.add(hand.controller);
  }

  async enter(mode, overlay) {
    const optionalFeatures = ['hand-tracking', 'dom-overlay'];
    const session = await navigator.xr.requestSession(mode, {
      requiredFeatures: ['local-floor'], optionalFeatures, domOverlay: { root: overlay },
    });
    this.session = session;
    session.addEventListener('visibilitychange', () => { if (session.visibilityState !== 'visible') this.#letGoAll(); });
    this.#placeFirst();
    this.view.enterHeadset(mode === 'immersive-vr');
    this.surroundings.applyTheme();
    this.surroundings.group.visible = mode === 'immersive-vr';
    this.view.camera.add(this.signs.group);
    try {
      await this.view.renderer.xr.setSession(session);
    } catch (error) {
      await session.end(); // otherwise the session would stay open without an image
      throw error;
    }
    this.view.renderer.xr.setFoveation(1);
    this.#placeWorld();
    await this.splats.enterHeadset();
  }

  // Places the scene within reach, or around the user, unless somebody has placed it: the program then has a room.
  #placeFirst() {
    this.room.set(this.parameters.current.room);
    if (this.room.isIdentity) this.room.placeFirst(this.splats.box);
  }

  /// Call when another scene, or the same in another size, is shown.
  sceneChanged() {
    if (this.session) this.#placeFirst();
  }

  leave() {
    return this.session?.end();
  }

  #left() {
    this.session = null;
    this.#letGoAll();
    this.panel.mesh.removeFromParent();
    this.signs.group.removeFromParent();
    this.surroundings.group.visible = false;
    this.teleport.end();
    this.view.world.position.set(0, 0, 0);
    this.view.world.quaternion.identity();
    this.view.world.scale.set(1, 1, 1);
    this.view.leaveHeadset();
    this.splats.leaveHeadset();
  }

  #letGoAll() {
    for (const hand of this.hands) {
      this.#letGo(hand);
      hand.squeezing = null;
    }
  }

  #placeWorld() {
    const { world } = this.view;
    this.room.xrFromWorld.decompose(world.position, world.quaternion, world.scale);
  }

  // After a jump of the world: fades in, and stores the new room.
  #jumped() {
    this.signs.fade();
    this.actions.setRoom(this.room.json);
  }

  /// Returns the scene to its initial placement.
  recentre() {
    this.room.set({ scale: 1, rotation: [1, 0, 0, 0], translation: [0, 0, 0] });
    this.room.placeFirst(this.splats.box);
    this.#jumped();
  }

  // Presses the button pointed at, takes the tool, or, if the other hand holds the tool, grabs the world.
  #take(hand) {
    const pointed = this.#pointedAt(hand);
    if (pointed) pointed.press();
    else if (this.#holding && this.#holding !== hand) {
      if (hand.isTracked) this.#grab(hand, true);
    } else if (this.hold.begin('headset')) this.#holding = hand;
  }

  #letGo(hand) {
    if (hand.squeezing && hand.isTracked) this.#grab(hand, false);
    if (this.#holding !== hand) return;
    this.#holding = null;
    this.hold.end('headset');
  }

  #pointedAt(hand) {
    if (this.panel.mesh.parent === hand.anchor) return null;
    const { origin, direction } = hand.pointing;
    return this.panel.buttonAt(origin, direction);
  }

  #grab(hand, on) {
    hand.squeezing = on ? this.room.toWorld(hand.pose.position) : null;
    // The other hand's grab is restarted too: one hand moves the world, two also rotate and scale it.
    for (const other of this.hands) if (other.squeezing) other.squeezing = this.room.toWorld(other.pose.position);
    if (!on) this.actions.setRoom(this.room.json);
  }

  /// Call before every frame. Unit of `now`: [s].
  update(now) {
    if (!this.session) return;
    const seconds = Math.min(now - this.#last, longestFrame);
    this.#last = now;
    this.frames.add(now);
    for (const hand of this.hands) this.#readButtons(hand);
    const grabbing = this.hands.filter((hand) => hand.squeezing);
    if (grabbing.length > 0) this.room.grab(grabbing.map((h) => h.squeezing), grabbing.map((h) => h.pose.position));
    this.#placeWorld();
    this.#showSigns(seconds, now);
    if (!this.#holding) return;
    const { position, orientation } = this.#holding.pose;
    this.hold.hand.copy(this.room.toWorld(position));
    this.hold.orientation.copy(this.room.turnToWorld(orientation));
  }

  #showSigns(seconds, now) {
    for (const hand of this.hands) {
      if (hand.isTracked) drawHand(hand.joints);
      else if (hand.controller) showHolding(hand.controller, hand === this.#holding);
    }
    const left = this.hands.find(({ source }) => source?.handedness === 'left')?.anchor;
    if (left && this.panel.mesh.parent !== left) left.add(this.panel.mesh);
    this.panel.hovered = this.hands.map((hand) => hand.source && this.#pointedAt(hand)?.name).find(Boolean) ?? null;
    this.panel.show(roomPanelContent(this), 1000 * now);
    const { view, live } = this;
    const tool = live.isFresh('measured_cp') ? view.camera.worldToLocal(view.world.localToWorld(new Vector3(...live.tool.position))) : null;
    this.signs.update({ tool, stop: this.statusBar.stop, seconds });
  }

  /// Plays a pulse on the controller that holds the tool.
  pulse(pulse) {
    const gamepad = this.#holding?.gamepad;
    if (gamepad) play(gamepad, pulse);
  }

  #readButtons(hand) {
    if (!hand.gamepad) return;
    if (hand.pressedNow(button.stop)) this.actions.stop();
    if (hand.pressedNow(button.leave)) this.leave();
    const { turn, ahead } = hand.readStick();
    if (turn !== 0) {
      this.room.turn(-turn * snap, this.view.camera.position);
      this.#jumped();
    }
    this.#aim(hand, ahead);
  }

  // Aims while the stick is forward; teleports once it is released.
  #aim(hand, ahead) {
    if (ahead) {
      this.#aiming = hand;
      const { origin, direction } = hand.pointing;
      this.teleport.aim(origin, direction);
    } else if (this.#aiming === hand) {
      this.#aiming = null;
      const target = this.teleport.end();
      const feet = this.view.camera.position.clone().setY(0);
      this.room.translation.add(this.room.toWorld(target).sub(this.room.toWorld(feet)));
      this.#jumped();
    }
  }
}
