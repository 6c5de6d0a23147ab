// The paper's Fig. 4: path of the tool and its contacts in the scene.

import { ColorManagement, LinearSRGBColorSpace, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

import { createAxes } from '../../shared/axes.js';
import { element } from '../../shared/dom.js';
import { niceFloor } from '../../shared/format.js';
import { applyTheme, themeValue } from '../../shared/theme.js';
import { centre, diagonal, frame } from './bounds.js';
import { toolOrientation, toolPosition } from './data.js';
import { formatFixed, formatTick } from './format.js';
import {
  contactNormals, contactPoints, floorGrid, forceArrows, kMinRange, rampColors, sceneCloud, toolMarker, toolPath,
} from './objects3d.js';
import { symbol } from './symbol.js';

const fieldOfView = 40; // vertical. Unit: [deg].
const halfHeight = Math.tan((0.5 * fieldOfView * Math.PI) / 180); // half height of the image at distance 1
const fitMargin = 1.12;
const firstDirection = new Vector3(0.62, -0.78, 0.5).normalize(); // from the middle to the camera
const markerShare = 0.015; // radius of the marker of an unknown tool, as a fraction of the view's extent
const normalShare = 0.035; // length of the normals, as a fraction of the view's extent
const forceShare = 0.08; // length of a large force, as a fraction of the view's extent; see forceArrows()
const axisReach = 24; // length of the axes in the corner. Unit: [px].
const labelLimit = 60; // largest number of onset labels; more would hide the view

// Colours of files and style sheet are displayed unchanged, without lighting.
ColorManagement.enabled = false;

function toggle(label, object, changed) {
  const box = element('input', { attributes: { type: 'checkbox', 'data-toggle': label.toLowerCase() } });
  box.checked = object !== null;
  box.disabled = object === null;
  box.addEventListener('change', () => {
    object.visible = box.checked;
    changed();
  });
  return element('label', { className: object ? '' : 'off' }, box, label);
}

function kMinLegend(run) {
  const [low, high] = kMinRange(run.contacts);
  const bar = element('span', { className: 'ramp' });
  bar.style.background = `linear-gradient(to right, ${rampColors.join(', ')})`;
  const kMin = element('span', { className: 'symbol', text: 'K' }, element('sub', { text: 'min' }));
  return element('span', { className: 'ramp-legend' }, kMin, formatTick(low), bar, formatFixed(high, 2));
}

function legendNote(run) {
  if (run.contacts.length === 0) return null;
  const text = run.contactsRecorded ? 'Contact points'
    : 'No contact points recorded; showing tool centres of the rows in contact';
  return element('p', { className: 'view-legend' }, element('span', { text }), kMinLegend(run));
}

function showMissing({ host, reset }) {
  reset.hidden = true;
  host.classList.add('missing');
  host.append(element('p', {
    text: 'The 3D view needs WebGL 2, which this browser does not support or has disabled. The charts and the table work without it.',
  }));
  return { available: false, setMarker() {}, redraw() {} };
}

// Labels t_a, t_b, ... at the contacts, as elements over the canvas.
function createLabels(host, run) {
  const labels = run.episodes.slice(0, labelLimit)
    .filter((e) => e.position)
    .map((e) => ({
      position: new Vector3(...e.position),
      node: element('span', { className: 'view-label' }, symbol('t', e.subscript)),
    }));
  host.append(...labels.map((label) => label.node));
  return (project) => {
    const placed = [];
    for (const { position, node } of labels) {
      const at = project(position);
      const free = at && !placed.some((p) => Math.abs(p.x - at.x) < 20 && Math.abs(p.y - at.y) < 16);
      node.style.visibility = free ? 'visible' : 'hidden';
      if (!free) continue;
      node.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px) translate(-50%, -150%)`;
      placed.push(at);
    }
  };
}

// Upper bound of the tool's extent from its handle.
function toolReach(parts) {
  return Math.max(...parts.map(({ semiAxes, position }) => Math.hypot(...position) + Math.max(...semiAxes)));
}

class View {
  available = true;
  #scene = new Scene();
  #camera = new PerspectiveCamera(fieldOfView, 1);
  #axes = createAxes(axisReach);
  #frame = 0;

  constructor({ host, controls, reset }, run, canvas, context) {
    this.run = run;
    this.host = host;
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, context });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.#addObjects();
    host.append(canvas, this.#axes.node, element('span', { className: 'scale', text: `Grid ${formatTick(this.gridStep)} m` }));
    this.placeLabels = createLabels(host, run);
    this.#addControls(controls);
    this.#setUpCamera();
    reset.addEventListener('click', () => this.resetCamera());
    new ResizeObserver(() => this.#resize()).observe(host);
    this.redraw();
  }

  #addObjects() {
    const { run } = this;
    const rows = [];
    const positions = [];
    for (let row = 0; row < run.rows; ++row) {
      const position = toolPosition(run, row);
      if (position) { rows.push(row); positions.push(position); }
    }
    Object.assign(this, frame(run, positions, run.tool ? toolReach(run.tool) : 0));
    this.extent = diagonal(this.box) || 1;
    this.gridStep = niceFloor(this.extent / 6);
    const ball = { semiAxes: Array(3).fill(markerShare * this.extent), position: [0, 0, 0], orientation: [0, 0, 0, 1] };
    const { contacts } = run;
    this.layers = {
      Scene: run.scene && sceneCloud(run.scene, this.extent, 1 / halfHeight),
      Path: rows.length > 1 ? toolPath(run, rows, positions, this.extent) : null,
      Contacts: contacts.length > 0 ? contactPoints(contacts) : null,
      Normals: contactNormals(contacts, normalShare * this.extent),
      Force: forceArrows(run, rows, positions, forceShare * this.extent),
    };
    this.marker = toolMarker(run.tool ?? [ball]);
    const grid = floorGrid(this.box, this.gridStep, this.box.min[2]);
    this.#scene.add(grid, this.marker, ...Object.values(this.layers).filter(Boolean));
  }

  #addControls(host) {
    const toggles = Object.entries(this.layers)
      .map(([name, layer]) => toggle(name, layer, () => this.#requestFrame()));
    host.append(element('div', { className: 'toggles', attributes: { role: 'group', 'aria-label': 'Shown in the view' } }, ...toggles));
    const note = legendNote(this.run);
    if (note) host.append(note);
  }

  #setUpCamera() {
    this.#camera.up.set(0, 0, 1);
    this.orbit = new OrbitControls(this.#camera, this.canvas);
    this.orbit.enableDamping = false;
    this.orbit.minDistance = 0.01 * this.extent;
    this.orbit.maxDistance = 20 * this.extent;
    this.#camera.near = 0.002 * this.extent;
    this.#camera.far = 60 * this.extent;
    this.orbit.addEventListener('change', () => this.#requestFrame());
    this.resetCamera();
  }

  // Distance from the centre at which the camera sees all of the outline.
  #fittingDistance() {
    const right = new Vector3().crossVectors(this.#camera.up, firstDirection).normalize();
    const up = new Vector3().crossVectors(firstDirection, right);
    const middle = new Vector3(...centre(this.box));
    const p = new Vector3();
    let distance = 0;
    for (const point of this.outline) {
      p.set(...point).sub(middle);
      const across = Math.abs(p.dot(right)) / (halfHeight * this.#camera.aspect);
      const upward = Math.abs(p.dot(up)) / halfHeight;
      distance = Math.max(distance, p.dot(firstDirection) + Math.max(across, upward));
    }
    return distance > 0 ? fitMargin * distance : this.extent;
  }

  resetCamera() {
    this.orbit.target.set(...centre(this.box));
    this.#camera.position.copy(this.orbit.target).addScaledVector(firstDirection, this.#fittingDistance());
    this.orbit.update();
    this.#requestFrame();
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    const first = this.size === undefined;
    this.size = { width, height };
    this.renderer.setSize(width, height);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
    if (first) this.resetCamera();
    this.#render();
  }

  // Frames are drawn on demand: nothing is animated.
  #requestFrame() {
    this.#frame ||= requestAnimationFrame(() => this.#render());
  }

  #render() {
    if (!this.size) return;
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
    this.renderer.render(this.#scene, this.#camera);
    this.#axes.turn(this.#camera);
    this.placeLabels((position) => this.project(position));
  }

  /// Position of a world point in the view, from its top left; null behind the camera. Unit: [px].
  project(position) {
    const p = new Vector3().copy(position).project(this.#camera);
    if (!this.size || Math.abs(p.z) > 1) return null;
    return { x: 0.5 * (p.x + 1) * this.size.width, y: 0.5 * (1 - p.y) * this.size.height };
  }

  /// Moves the tool to its pose in a row.
  setMarker(row) {
    const position = toolPosition(this.run, row);
    this.marker.visible = position !== null;
    if (position) this.marker.position.set(...position);
    this.marker.quaternion.set(...toolOrientation(this.run, row)).normalize();
    this.#requestFrame();
  }

  redraw() {
    applyTheme(this.#scene);
    this.renderer.setClearColor(themeValue('--view'));
    this.#render();
  }
}

/// Builds the 3D view in `places.host`, or shows a message there if WebGL 2 is missing.
export function createView(places, run) {
  const canvas = element('canvas', { attributes: { 'aria-label': 'Tool path and contacts in 3D' } });
  // preserveDrawingBuffer: the view can be printed.
  const context = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
  return context ? new View(places, run, canvas, context) : showMissing(places);
}
