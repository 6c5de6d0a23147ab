// The 3D view: camera, light, frames. The world is drawn in its own frame, z up and in metres; only in a headset the
// group `world` is moved, as set by the room.

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
const mostSmaller = 1.75; // largest factor by which an object appears smaller to keep another one in view
const keyTurn = Math.PI / 36; // rotation per press of an arrow key. Unit: [rad].
const keyZoom = 1.1;
const axisReach = 22; // length of the axes in the corner. Unit: [px].

export class View {
  frames = 0; // number of drawn frames
  sceneFrames = 0; // number of frames in which the scene was redrawn
  idle = 0; // number of consecutive ticks without a redraw
  world = new Group();
  #scene = new Scene();
  #dirty = true;
  #sceneDirty = true;
  #perFrame = [];
  #opaque = true;
  #atDesk = null; // copy of the camera before entering a headset

  constructor(host, canvas) {
    this.host = host;
    this.canvas = canvas;
    // No multisampling: splats have soft edges.
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

  /// Requests a redraw of everything.
  invalidate() {
    this.#sceneDirty = true;
    this.invalidateFront();
  }

  /// Requests a redraw of the objects in front of the scene.
  invalidateFront() {
    this.#dirty = true;
  }

  /// Sets the themed materials below `root` to the current theme.
  applyTheme(root) {
    applyTheme(root);
    this.setBackground(this.#opaque);
  }

  setBackground(opaque) {
    this.#opaque = opaque;
    this.renderer.setClearColor(themeValue('--view'), opaque ? 1 : 0);
    this.invalidate();
  }

  /// Moves the camera, without rotating it, to show all of a Box3 in the middle of the part of the view that `covered`,
  /// {top, bottom} in pixels, leaves free. The Box3 `beside` is also in view unless `box` became more than
  /// `mostSmaller` times smaller.
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

  // Camera position relative to the centre of a box that centres the box and shows all of `beside`, see frameAll().
  #fit(box, covered, beside) {
    const middle = box.getCenter(new Vector3());
    const alone = new Frame({ ...this.#sides(covered), inside: this.#cornersOf(box, middle) });
    const both = new Frame({ ...alone, beside: this.#cornersOf(beside, middle) });
    const [near, far] = [alone.leastDistance(), both.leastDistance()];
    const distance = far < mostSmaller * near ? far : near;
    return { distance, ...alone.middleAt(distance) };
  }

  // Bounds {low, high, side} of the free part of the view at depth 1, with a margin.
  #sides({ top, bottom }) {
    const half = Math.tan((0.5 * fieldOfView * Math.PI) / 180) / fitMargin;
    const height = Math.max(this.canvas.clientHeight, 1);
    return { low: half * (-1 + (2 * bottom) / height), high: half * (1 - (2 * top) / height), side: half * this.camera.aspect };
  }

  // Corners of a Box3 relative to `origin` in the camera's axes: [right, up, forward] each; none for an empty box.
  #cornersOf(box, origin) {
    if (box.isEmpty()) return [];
    const axes = Object.values(this.axesOfCamera);
    return [0, 1, 2, 3, 4, 5, 6, 7].map((k) => {
      const corner = new Vector3(...['x', 'y', 'z'].map((axis, bit) => (k & (1 << bit) ? box.max : box.min)[axis])).sub(origin);
      return axes.map((axis) => corner.dot(axis));
    });
  }

  /// Looks at a point of the world from `distance`, keeping the viewing direction.
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

  /// Distance at which an object of a radius fills a fraction of the view's height. Unit: [m].
  distanceFor(radius, share) {
    return radius / (share * Math.tan((0.5 * fieldOfView * Math.PI) / 180));
  }

  /// Direction on the page from the middle of the view to a point of the world, also for points behind the camera.
  towards(point) {
    const seen = new Vector3(...point).applyMatrix4(this.camera.matrixWorldInverse);
    return [seen.x, -seen.y];
  }

  /// Saves the camera, which a headset controls, and sets its near and far planes for a room.
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

  /// Position of a world point, in pixels from the top left of the page; null behind the camera.
  project(point) {
    const p = new Vector3(...point).project(this.camera);
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return Math.abs(p.z) > 1 ? null : [left + 0.5 * (p.x + 1) * width, top + 0.5 * (1 - p.y) * height];
  }

  /// Ray through a point of the page, in the world.
  rayAt({ clientX, clientY }) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new Vector2((2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height);
    const caster = new Raycaster();
    caster.setFromCamera(at, this.camera);
    return caster.ray;
  }

  /// Size of a pixel at the depth of a world point. Unit: [m].
  pixelAt(point) {
    const depth = new Vector3(...point).sub(this.camera.position).dot(this.camera.getWorldDirection(new Vector3()));
    return (2 * Math.max(depth, this.camera.near) * Math.tan((0.5 * fieldOfView * Math.PI) / 180)) / this.canvas.clientHeight;
  }

  /// Right, up and forward axes of the camera, in the world.
  get axesOfCamera() {
    const [right, up, back] = [new Vector3(), new Vector3(), new Vector3()];
    this.camera.matrixWorld.extractBasis(right, up, back);
    return { right, up, forward: back.negate() };
  }
}

/// Bounding box of points of the world, expanded by `room`.
export function boxAround(points, room) {
  return new Box3().setFromPoints(points.map((p) => new Vector3(...p))).expandByScalar(room);
}
