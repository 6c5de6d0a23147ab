// The 3D view: camera, light, frames. The world is drawn as it is, z up and in metres; only in a headset the
// group `world` is moved, to where the room wants it.

import {
  Box3, DirectionalLight, Group, HemisphereLight, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

import { createAxes } from '../../shared/axes.js';
import { applyTheme, followTheme, themeValue } from '../../shared/theme.js';
import { Backdrop, sceneLayer } from './backdrop.js';
import { Frame } from './frame.js';

const fieldOfView = 45; // vertical. Unit: [deg].
const firstDirection = new Vector3(0.62, -0.78, 0.5).normalize(); // from the middle to the camera
const fitMargin = 1.06;
const mostSmaller = 1.75; // times, that a thing is seen for another to be in view beside it
const keyTurn = Math.PI / 36; // a press of an arrow key. Unit: [rad].
const keyZoom = 1.1;
const axisReach = 22; // of the axes in the corner. Unit: [px].

export class View {
  frames = 0; // that have been drawn
  sceneFrames = 0; // in which the scene was, too
  idle = 0; // times in a row that there was nothing to draw
  world = new Group();
  #scene = new Scene();
  #dirty = true;
  #sceneDirty = true;
  #perFrame = [];
  #opaque = true;
  #atDesk = null; // the camera before a headset had it

  constructor(host, canvas) {
    this.host = host;
    this.canvas = canvas;
    // Splats are soft by themselves: multisampling would only cost time.
    this.renderer = new WebGLRenderer({ canvas, antialias: false, alpha: true });
    this.camera = new PerspectiveCamera(fieldOfView, 1, 0.001, 100);
    this.camera.up.set(0, 0, 1);
    this.camera.layers.enable(sceneLayer);
    this.backdrop = new Backdrop(this.renderer, this.#scene);
    this.camera.position.copy(firstDirection);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.addEventListener('change', () => this.invalidate());
    canvas.addEventListener('webglcontextrestored', () => this.onRestored?.());
    this.#addLight();
    this.#scene.add(this.world, this.camera);
    this.axes = createAxes(axisReach);
    host.append(this.axes.node);
    new ResizeObserver(() => this.#resize()).observe(host);
    followTheme(() => this.applyTheme(this.#scene));
    this.#followKeys();
    this.renderer.setAnimationLoop((time, frame) => this.#tick(time, frame));
  }

  #addLight() {
    const lamp = new DirectionalLight(0xffffff, 1.8);
    lamp.position.set(0.4, 1, 0.6);
    this.camera.add(lamp, lamp.target);
    const sky = new HemisphereLight(0xffffff, 0x9a9fa8, 2.4);
    sky.position.set(0, 0, 1);
    this.#scene.add(sky);
  }

  add(...objects) {
    this.#scene.add(...objects);
  }

  /// Calls `work(seconds, frame)` before every frame, drawn or not. `frame` is an XRFrame in a headset.
  everyFrame(work) {
    this.#perFrame.push(work);
  }

  /// All is to be drawn anew.
  invalidate() {
    this.#sceneDirty = true;
    this.invalidateFront();
  }

  /// What lies before the scene is.
  invalidateFront() {
    this.#dirty = true;
  }

  /// Gives the themed materials below `root` the colours of the theme that is on.
  applyTheme(root) {
    applyTheme(root);
    this.setBackground(this.#opaque);
  }

  setBackground(opaque) {
    this.#opaque = opaque;
    this.renderer.setClearColor(themeValue('--view'), opaque ? 1 : 0);
    this.invalidate();
  }

  /// Moves the camera so that it sees all of a Box3 from where it looks now, in the middle of the part of the view that `covered`
  /// leaves free: {top, bottom} in pixels. The Box3 `beside` is in view, too, where that makes the first at most `mostSmaller` smaller.
  frameAll(box, covered = { top: 0, bottom: 0 }, beside = new Box3()) {
    if (box.isEmpty()) return;
    const middle = box.getCenter(new Vector3());
    const radius = Math.max(0.5 * box.getSize(new Vector3()).length(), 1e-3);
    this.camera.updateMatrixWorld();
    const { distance, right, up } = this.#fit(box, covered, beside);
    const axes = this.axesOfCamera;
    this.orbit.target.copy(middle).addScaledVector(axes.right, right).addScaledVector(axes.up, up);
    this.camera.position.copy(this.orbit.target).addScaledVector(axes.forward, -distance);
    this.camera.near = 0.002 * radius;
    this.camera.far = 200 * radius;
    this.camera.updateProjectionMatrix();
    this.orbit.minDistance = 0.02 * radius;
    this.orbit.maxDistance = 50 * radius;
    this.orbit.update();
    this.invalidate();
  }

  // From how far, and how far beside the middle of a box, a camera has all of it in the middle, and all of `beside` in view.
  #fit(box, covered, beside) {
    const middle = box.getCenter(new Vector3());
    const alone = new Frame({ ...this.#sides(covered), inside: this.#cornersOf(box, middle) });
    const both = new Frame({ ...alone, beside: this.#cornersOf(beside, middle) });
    const [near, far] = [alone.leastDistance(), both.leastDistance()];
    const distance = far < mostSmaller * near ? far : near;
    return { distance, ...alone.middleAt(distance) };
  }

  // What a camera sees one unit ahead, {low, high, side}, with a margin.
  #sides({ top, bottom }) {
    const half = Math.tan((0.5 * fieldOfView * Math.PI) / 180) / fitMargin;
    const height = Math.max(this.canvas.clientHeight, 1);
    return { low: half * (-1 + (2 * bottom) / height), high: half * (1 - (2 * top) / height), side: half * this.camera.aspect };
  }

  // Of a Box3, seen from `origin` along the camera's axes: [right, up, forward] each; none of an empty one.
  #cornersOf(box, origin) {
    if (box.isEmpty()) return [];
    const axes = Object.values(this.axesOfCamera);
    return [0, 1, 2, 3, 4, 5, 6, 7].map((k) => {
      const corner = new Vector3(...['x', 'y', 'z'].map((axis, bit) => (k & (1 << bit) ? box.max : box.min)[axis])).sub(origin);
      return axes.map((axis) => corner.dot(axis));
    });
  }

  /// Turns to a point of the world and looks at it from `distance`, from the side that it is seen from now.
  focus(point, distance) {
    const away = this.camera.position.clone().sub(this.orbit.target).normalize();
    this.orbit.target.copy(point);
    this.orbit.minDistance = Math.min(this.orbit.minDistance, 0.5 * distance);
    this.camera.near = Math.min(this.camera.near, 0.05 * distance);
    this.camera.updateProjectionMatrix();
    this.camera.position.copy(point).addScaledVector(away, distance);
    this.orbit.update();
    this.invalidate();
  }

  /// From where something of a radius fills a share of the height of the view. Unit: [m].
  distanceFor(radius, share) {
    return radius / (share * Math.tan((0.5 * fieldOfView * Math.PI) / 180));
  }

  /// The way from the middle of the view to a point of the world, as on the page, wherever the point is.
  towards(point) {
    const seen = new Vector3(...point).applyMatrix4(this.camera.matrixWorldInverse);
    return [seen.x, -seen.y];
  }

  /// In a headset the camera is the head, and the room's size says how near and far it sees.
  enterHeadset(opaque) {
    this.#atDesk = this.camera.clone();
    Object.assign(this.camera, { near: 0.02, far: 1000 });
    this.setBackground(opaque);
  }

  leaveHeadset() {
    this.camera.copy(this.#atDesk, false);
    for (const part of [this.world, this.camera]) part.updateMatrixWorld(true);
    this.setBackground(true);
    this.#resize();
  }

  #followKeys() {
    const turns = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    this.canvas.addEventListener('keydown', ({ key }) => {
      if (!this.orbit.enabled) return;
      if (key in turns) {
        this.orbit.rotateLeft(keyTurn * turns[key][0]);
        this.orbit.rotateUp(keyTurn * turns[key][1]);
      } else if (key === '+') this.orbit.dollyIn(keyZoom);
      else if (key === '-') this.orbit.dollyOut(keyZoom);
    });
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0 || this.renderer.xr.isPresenting) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  #tick(time, frame) {
    for (const work of this.#perFrame) work(time / 1000, frame);
    if (!this.#dirty && !this.renderer.xr.isPresenting) {
      ++this.idle;
      return;
    }
    this.#dirty = false;
    this.idle = 0;
    this.#draw();
    this.axes.turn(this.camera);
    ++this.frames;
  }

  #draw() {
    if (this.#sceneDirty) ++this.sceneFrames;
    if (this.renderer.xr.isPresenting) this.renderer.render(this.#scene, this.camera);
    else this.backdrop.draw(this.camera, this.#sceneDirty);
    this.#sceneDirty = this.renderer.xr.isPresenting;
  }

  /// Where a point of the world is, in pixels from the top left of the page; null behind the camera.
  project(point) {
    const p = new Vector3(...point).project(this.camera);
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return Math.abs(p.z) > 1 ? null : [left + 0.5 * (p.x + 1) * width, top + 0.5 * (1 - p.y) * height];
  }

  /// The ray through a point of the page, in the world.
  rayAt({ clientX, clientY }) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new Vector2((2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height);
    const caster = new Raycaster();
    caster.setFromCamera(at, this.camera);
    return caster.ray;
  }

  /// The size of a pixel at a point of the world. Unit: [m].
  pixelAt(point) {
    const depth = new Vector3(...point).sub(this.camera.position).dot(this.camera.getWorldDirection(new Vector3()));
    return (2 * Math.max(depth, this.camera.near) * Math.tan((0.5 * fieldOfView * Math.PI) / 180)) / this.canvas.clientHeight;
  }

  /// The camera's right, up and forward in the world.
  get axesOfCamera() {
    const [right, up, back] = [new Vector3(), new Vector3(), new Vector3()];
    this.camera.matrixWorld.extractBasis(right, up, back);
    return { right, up, forward: back.negate() };
  }
}

/// The box around some points of the world with room to all sides.
export function boxAround(points, room) {
  return new Box3().setFromPoints(points.map((p) => new Vector3(...p))).expandByScalar(room);
}
