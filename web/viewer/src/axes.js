// The world's axes in a corner of the view, turning with the camera.

import { Vector3 } from 'three';

const reach = 22; // of an axis from the middle. Unit: [px].
const svgNamespace = 'http://www.w3.org/2000/svg';

function svg(tag, attributes, ...children) {
  const node = document.createElementNS(svgNamespace, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

function createAxis(name, direction) {
  const line = svg('line', {});
  const label = svg('text', { 'text-anchor': 'middle', 'dominant-baseline': 'central' }, name);
  return { line, label, node: svg('g', { class: `axis-${name}` }, line, label), direction: new Vector3(...direction) };
}

/// The drawing and a function that turns it to a camera.
export function createAxes() {
  const axes = [createAxis('x', [1, 0, 0]), createAxis('y', [0, 1, 0]), createAxis('z', [0, 0, 1])];
  const node = svg('svg', { class: 'world-axes', viewBox: '-34 -34 68 68', role: 'img', 'aria-label': 'World axes' });
  const turn = (camera) => {
    const nearerLast = axes.map((axis) => ({ axis, seen: axis.direction.clone().transformDirection(camera.matrixWorldInverse) }))
      .sort((a, b) => a.seen.z - b.seen.z);
    for (const { axis, seen } of nearerLast) {
      axis.line.setAttribute('x2', (reach * seen.x).toFixed(1));
      axis.line.setAttribute('y2', (-reach * seen.y).toFixed(1));
      axis.label.setAttribute('x', ((reach + 8) * seen.x).toFixed(1));
      axis.label.setAttribute('y', (-(reach + 8) * seen.y).toFixed(1));
    }
    node.append(...nearerLast.map(({ axis }) => axis.node));
  };
  return { node, turn };
}
