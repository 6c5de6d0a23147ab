// Floor and horizon in a headset, as references for the vertical and for distances.

import { BackSide, BufferAttribute, BufferGeometry, Color, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, SphereGeometry } from 'three';

import { themeValue } from '../../shared/theme.js';

const reach = 8; // extent of the floor's lines to each side. Unit: [m].
const farAway = 400; // radius of the sky. Unit: [m].
const order = -10; // drawn before the splats
const deepest = 0.25; // largest fraction of the ink colour in the sky

export class Surroundings {
  group = new Group();

  constructor() {
    this.sky = new Mesh(new SphereGeometry(farAway, 24, 32), new MeshBasicMaterial({ vertexColors: true, side: BackSide, depthWrite: false, depthTest: false }));
    this.sky.renderOrder = order;
    this.floor = new LineSegments(gridLines(), new LineBasicMaterial({ transparent: true, opacity: 0.55, depthWrite: false }));
    this.floor.material.userData.color = '--muted';
    this.floor.renderOrder = order + 1;
    this.group.add(this.sky, this.floor);
    this.group.visible = false;
  }

  /// Sets the colours of the theme: sky and ground are darker than the horizon.
  applyTheme() {
    const [view, ink] = ['--view', '--ink'].map((name) => new Color(themeValue(name)));
    const isDark = view.g < ink.g;
    const horizon = isDark ? view.clone().lerp(ink, deepest) : view;
    const away = isDark ? view : view.clone().lerp(ink, deepest);
    const { position } = this.sky.geometry.attributes;
    const colors = new Float32Array(3 * position.count);
    for (let i = 0; i < position.count; ++i) {
      const up = position.getY(i) / farAway;
      const share = up >= 0 ? 0.6 * Math.sqrt(up) : Math.min(0.4 + 0.6 * Math.sqrt(-up), 1);
      horizon.clone().lerp(away, share).toArray(colors, 3 * i);
    }
    this.sky.geometry.setAttribute('color', new BufferAttribute(colors, 3));
    this.floor.material.color.set(themeValue('--muted'));
  }
}

// Grid of separate segments of 1 m: long lines that start behind the camera are not drawn on all systems.
function gridLines() {
  const points = [];
  for (let k = -reach; k <= reach; ++k) {
    for (let i = -reach; i < reach; ++i) points.push(k, 0, i, k, 0, i + 1, i, 0, k, i + 1, 0, k);
  }
  return new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
}
