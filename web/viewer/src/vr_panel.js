// Panel at the left hand in a headset: status text, and buttons pressed by a ray.

import { CanvasTexture, Mesh, MeshBasicMaterial, PlaneGeometry, Raycaster, SRGBColorSpace, Vector3 } from 'three';

import { themeValue } from '../../shared/theme.js';
import { rampColors } from './ramp.js';

const size = [560, 720]; // Unit: [px].
const width = 0.24; // Unit: [m].
const margin = 24; // Unit: [px].
const line = 40; // Unit: [px].
const linesAtMost = 5;
const buttons = { top: 270, height: 62, gap: 10, columns: 2 }; // Unit: [px].
const redrawEvery = 150; // Unit: [ms].

export class RoomPanel {
  hovered = null; // name of the button pointed at, or null
  lines = [];
  #drawn = '';
  #drawnAt = -Infinity;
  #caster = new Raycaster();

  /// `buttons` are {name, label(): text, press()}.
  constructor(list) {
    this.buttons = list;
    this.canvas = Object.assign(document.createElement('canvas'), { width: size[0], height: size[1] });
    this.texture = new CanvasTexture(this.canvas);
    this.texture.colorSpace = SRGBColorSpace;
    const material = new MeshBasicMaterial({ map: this.texture, transparent: true, depthTest: false });
    this.mesh = new Mesh(new PlaneGeometry(width, (width * size[1]) / size[0]), material);
    this.mesh.position.set(0, 0.14, -0.06);
    this.mesh.rotation.x = -Math.PI / 5;
    this.mesh.renderOrder = 20;
  }

  /// Whether the panel is in a scene and visible.
  get isShown() {
    let part = this.mesh;
    while (part.visible && part.parent) part = part.parent;
    return part.isScene === true;
  }

  /// Button that a ray in WebXR's space points at, or null.
  buttonAt(origin, direction) {
    if (!this.mesh.parent) return null;
    this.mesh.updateWorldMatrix(true, false);
    this.#caster.set(origin, direction);
    const [met] = this.#caster.intersectObject(this.mesh);
    if (!met) return null;
    const [x, y] = [met.uv.x * size[0], (1 - met.uv.y) * size[1]];
    return this.buttons.find((_, i) => isIn(boxOf(i), x, y)) ?? null;
  }

  /// Centre of a button, in WebXR's space.
  placeOf(name) {
    const [x, y, w, h] = boxOf(this.buttons.findIndex((b) => b.name === name));
    this.mesh.updateWorldMatrix(true, false);
    const local = new Vector3(((x + 0.5 * w) / size[0] - 0.5) * width, (0.5 - (y + 0.5 * h) / size[1]) * (width * size[1]) / size[0], 0);
    return local.applyMatrix4(this.mesh.matrixWorld);
  }

  /// Shows lines of text, the first in the colour of `level`, and the legend.
  show({ lines, level, legend }, now) {
    this.lines = lines;
    const key = JSON.stringify([lines, level, legend, this.hovered, this.buttons.map((b) => b.label())]);
    if (key === this.#drawn || now - this.#drawnAt < redrawEvery) return;
    this.#drawn = key;
    this.#drawnAt = now;
    const context = this.canvas.getContext('2d');
    context.clearRect(0, 0, ...size);
    fillBox(context, [0, 0, ...size], themeValue('--card'), 28);
    context.font = '30px system-ui, sans-serif';
    lines.slice(0, linesAtMost).forEach((text, i) => {
      context.fillStyle = themeValue(i === 0 ? `--${level}` : '--ink');
      context.fillText(text, margin, 50 + line * i, size[0] - 2 * margin);
    });
    this.buttons.forEach((button, i) => this.#drawButton(context, button, boxOf(i)));
    drawLegend(context, legend);
    this.texture.needsUpdate = true;
  }

  #drawButton(context, { name, label }, [x, y, w, h]) {
    fillBox(context, [x, y, w, h], themeValue(name === 'stop' ? '--stop' : name === this.hovered ? '--pressed' : '--hover'), 12);
    context.strokeStyle = themeValue(name === this.hovered ? '--focus' : '--border');
    context.lineWidth = name === this.hovered ? 5 : 2;
    context.stroke();
    context.fillStyle = name === 'stop' ? '#ffffff' : themeValue('--ink');
    context.textAlign = 'center';
    context.fillText(label(), x + 0.5 * w, y + 0.5 * h + 10, w - 12);
    context.textAlign = 'left';
  }
}

function boxOf(i) {
  const w = (size[0] - 2 * margin - buttons.gap) / buttons.columns;
  const [row, column] = [Math.floor(i / buttons.columns), i % buttons.columns];
  return [margin + column * (w + buttons.gap), buttons.top + row * (buttons.height + buttons.gap), w, buttons.height];
}

const isIn = ([x, y, w, h], px, py) => px >= x && px <= x + w && py >= y && py <= y + h;

function fillBox(context, [x, y, w, h], color, radius) {
  context.fillStyle = color;
  context.beginPath();
  context.roundRect(x, y, w, h, radius);
  context.fill();
}

// Scale of the force arrows and colours of contacts.
function drawLegend(context, { newtons, centimetres }) {
  const y = size[1] - 62;
  context.font = '24px system-ui, sans-serif';
  context.fillStyle = themeValue('--ink');
  context.fillText(`Force arrow: ${centimetres} cm per ${newtons} N`, margin, y);
  context.fillText('touching', margin, y + 38);
  const gradient = context.createLinearGradient(150, 0, 380, 0);
  rampColors.forEach((color, i) => gradient.addColorStop(i / (rampColors.length - 1), color));
  fillBox(context, [150, y + 20, 230, 18], gradient, 9);
  context.fillStyle = themeValue('--ink');
  context.fillText('deep', 396, y + 38);
}
