// A few words at the left hand in a headset, where the page's panels are not seen.

import { CanvasTexture, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace } from 'three';

import { themeValue } from '../../shared/theme.js';

const size = [512, 160]; // Unit: [px].
const width = 0.12; // Unit: [m].

export class Sign {
  #shown = '';

  constructor() {
    this.canvas = Object.assign(document.createElement('canvas'), { width: size[0], height: size[1] });
    this.texture = new CanvasTexture(this.canvas);
    this.texture.colorSpace = SRGBColorSpace;
    const material = new MeshBasicMaterial({ map: this.texture, transparent: true, depthTest: false });
    this.mesh = new Mesh(new PlaneGeometry(width, (width * size[1]) / size[0]), material);
    this.mesh.position.set(0, 0.06, -0.02);
    this.mesh.rotation.x = -Math.PI / 4;
    this.mesh.renderOrder = 20;
  }

  /// Shows up to three lines of text.
  show(lines) {
    const text = lines.join('\n');
    if (text === this.#shown) return;
    this.#shown = text;
    const context = this.canvas.getContext('2d');
    context.clearRect(0, 0, ...size);
    context.fillStyle = themeValue('--card');
    context.beginPath();
    context.roundRect(0, 0, ...size, 24);
    context.fill();
    context.fillStyle = themeValue('--ink');
    context.font = '36px system-ui, sans-serif';
    lines.slice(0, 3).forEach((line, i) => context.fillText(line, 24, 48 + 46 * i, size[0] - 48));
    this.texture.needsUpdate = true;
  }
}
