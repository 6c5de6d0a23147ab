// World axes in a corner of the view, which turn with the camera.

import { Vector3 } from 'three';

import { svg } from './dom.js';

const labelAt = 8; // distance of a label from the end of its axis. Unit: [px].
const margin = 12; // around the ends, for the labels. Unit: [px].

function createAxis(name, direction) {
  const line = svg('line');
  const label = svg('text', { 'text-anchor': 'middle', 'dominant-baseline': 'central' }, name);
  return { line, label, node: svg('g', { class: `axis-${name}` }, line, label), direction: new Vector3(...direction) };
}

/// Returns {node, turn(camera)}; `turn` draws the axes as the camera sees them. An axis is `reach` pixels long.
export function createAxes(reach) {
  const axes = [createAxis('x', [1, 0, 0]), createAxis('y', [0, 1, 0]), createAxis('z', [0, 0, 1])];
  const half = reach + margin;
  const node = svg('svg', { class: 'world-axes', viewBox: [-half, -half, 2 * half, 2 * half].join(' '), role: 'img', 'aria-label': 'World axes' });
  const turn = (camera) => {
    const nearerLast = axes.map((axis) => ({ axis, seen: axis.direction.clone().transformDirection(camera.matrixWorldInverse) }))
      .sort((a, b) => a.seen.z - b.seen.z);
    for (const { axis, seen } of nearerLast) {
      axis.line.setAttribute('x2', (reach * seen.x).toFixed(1));
      axis.line.setAttribute('y2', (-reach * seen.y).toFixed(1));
      axis.label.setAttribute('x', ((reach + labelAt) * seen.x).toFixed(1));
      axis.label.setAttribute('y', (-(reach + labelAt) * seen.y).toFixed(1));
    }
    node.append(...nearerLast.map(({ axis }) => axis.node));
  };
  return { node, turn };
}
