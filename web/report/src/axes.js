// The world axes in a corner of the view, turning with the camera.

import { Vector3 } from 'three';

const reach = 24; // of an axis from the middle. Unit: [px].
const svgNamespace = 'http://www.w3.org/2000/svg';

function svg(tag, attributes) {
  const node = document.createElementNS(svgNamespace, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
}

/// Returns the drawing and a function that turns it to the camera.
export function createAxes() {
  const axes = [['x', 1, 0, 0], ['y', 0, 1, 0], ['z', 0, 0, 1]].map(([name, ...direction]) => {
    const group = svg('g', { class: `axis axis-${name}` });
    const line = svg('line', { x1: 0, y1: 0 });
    const label = svg('text', { 'text-anchor': 'middle', 'dominant-baseline': 'central' });
    label.textContent = name;
    group.append(line, label);
    return { group, line, label, direction: new Vector3(...direction) };
  });
  const node = svg('svg', { class: 'world-axes', viewBox: '-36 -36 72 72', role: 'img', 'aria-label': 'World axes' });
  const seen = new Vector3();
  const turn = (camera) => {
    for (const axis of axes) {
      seen.copy(axis.direction).transformDirection(camera.matrixWorldInverse);
      axis.depth = seen.z;
      axis.line.setAttribute('x2', (reach * seen.x).toFixed(1));
      axis.line.setAttribute('y2', (-reach * seen.y).toFixed(1));
      axis.label.setAttribute('x', ((reach + 8) * seen.x).toFixed(1));
      axis.label.setAttribute('y', (-(reach + 8) * seen.y).toFixed(1));
    }
    // Nearer axes are painted later.
    node.append(...[...axes].sort((a, b) => a.depth - b.depth).map((axis) => axis.group));
  };
  return { node, turn };
}
