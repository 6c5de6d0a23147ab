// Signs in front of the eyes in a headset: a fade at every jump, a frame while the force is stopped, an arrow to a tool
// out of view.

import { CanvasTexture, ConeGeometry, Group, Mesh, MeshBasicMaterial, PlaneGeometry, RingGeometry, SRGBColorSpace, Vector3 } from 'three';

import { themeValue } from '../../shared/theme.js';

const fadeTime = 0.25; // duration of a fade. Unit: [s].
const outOfView = Math.cos((32 * Math.PI) / 180); // cosine of the angle from the viewing direction
const arrowAt = 0.16; // distance from the middle, at a depth of 0.5 m. Unit: [m].
const ahead = new Vector3(0, 0, -1);
const up = new Vector3(0, 1, 0);
const textSize = [760, 170]; // Unit: [px].
const [firstLine, lineHeight] = [70, 62]; // Unit: [px].

function inFront(geometry, color, order, options = {}) {
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ color, transparent: true, depthTest: false, depthWrite: false, ...options }));
  mesh.renderOrder = order;
  mesh.frustumCulled = false;
  mesh.visible = false;
  return mesh;
}

export class EyeSigns {
  group = new Group(); // to be added to the camera
  #fade = 0;
  #text = '';

  constructor() {
    this.dark = inFront(new PlaneGeometry(4, 4), '#000000', 40);
    this.dark.position.z = -0.3;
    this.frame = inFront(new RingGeometry(0.33, 0.95, 64), themeValue('--stop'), 38, { opacity: 0.75 });
    this.frame.position.z = -0.4;
    this.arrow = inFront(new ConeGeometry(0.014, 0.05, 16), themeValue('--tool'), 39);
    this.canvas = Object.assign(document.createElement('canvas'), { width: textSize[0], height: textSize[1] });
    this.texture = new CanvasTexture(this.canvas);
    this.texture.colorSpace = SRGBColorSpace;
    this.words = inFront(new PlaneGeometry(0.32, (0.32 * textSize[1]) / textSize[0]), '#ffffff', 39, { map: this.texture });
    this.words.position.set(0, 0.16, -0.5);
    this.group.add(this.dark, this.frame, this.arrow, this.words);
  }

  fade() {
    this.#fade = 1;
  }

  /// `tool` is its position in the camera frame, a Vector3, or null; `stop` is the reason for a stopped force, or
  /// empty.
  update({ tool, stop, seconds }) {
    this.#fade = Math.max(0, this.#fade - seconds / fadeTime);
    this.dark.material.opacity = this.#fade;
    this.dark.visible = this.#fade > 0;
    this.frame.visible = this.words.visible = stop !== '';
    if (stop) this.#say([stop, 'Press Resume on the panel.']);
    this.#point(tool);
  }

  // Points the arrow along the yaw and pitch that turn the head to the tool; for a tool behind the head, to a side.
  #point(tool) {
    const direction = tool?.clone().normalize();
    this.arrow.visible = Boolean(direction) && direction.dot(ahead) < outOfView;
    if (!this.arrow.visible) return;
    const { x, y, z } = direction;
    const aside = new Vector3(Math.atan2(x, -z), Math.atan2(y, Math.hypot(x, z)), 0).normalize();
    this.arrow.quaternion.setFromUnitVectors(up, aside);
    this.arrow.position.copy(aside).multiplyScalar(arrowAt).setZ(-0.5);
  }

  #say(lines) {
    const text = lines.join('\n');
    if (text === this.#text) return;
    this.#text = text;
    const context = this.canvas.getContext('2d');
    context.fillStyle = themeValue('--stop');
    context.fillRect(0, 0, ...textSize);
    context.fillStyle = '#ffffff';
    context.font = '600 46px system-ui, sans-serif';
    context.textAlign = 'center';
    lines.forEach((line, i) => context.fillText(line, 0.5 * textSize[0], firstLine + i * lineHeight, textSize[0] - 40));
    this.texture.needsUpdate = true;
  }
}
