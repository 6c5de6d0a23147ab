// Marks over the view, in pixels of the page: a ring around a small tool, an arrow to a tool out of view, and the
// distance to the surface.

import { svg } from '../../shared/dom.js';

const leastRing = 14; // least radius of the ring. Unit: [px].
const large = 26; // radius of a tool from which on no ring is needed. Unit: [px].
const nameRoom = 20; // space needed for the name above the ring. Unit: [px].
const labelRoom = 60; // distance from the ring within which two labels would overlap. Unit: [px].
const margin = 30; // distance of the arrow from the border of the view. Unit: [px].

export class Overlay {
  #key = '';

  constructor(view) {
    this.view = view;
    this.ring = svg('circle', { class: 'tool-ring' });
    this.arrow = svg('path', { class: 'tool-arrow', d: 'M18 0L-8 -13L-3 0L-8 13Z' });
    this.name = svg('text', { class: 'tool-name' });
    this.distance = svg('text', { class: 'tool-distance' });
    this.node = svg('svg', { class: 'overlay', 'aria-hidden': 'true' }, this.ring, this.arrow, this.name, this.distance);
    document.body.append(this.node); // not in the view, which is below the bar
  }

  /// `tool` is {at, towards, radius, distant, covered}: its position on the page or null, its direction from the middle
  /// of the view, its radius, the distance {text, at} or null, and the covered heights {top, bottom}. Null hides it.
  show(tool) {
    const key = JSON.stringify(tool);
    if (key === this.#key) return;
    this.#key = key;
    for (const part of this.node.children) part.classList.add('unseen');
    if (!tool) return;
    const seen = this.view.canvas.getBoundingClientRect();
    const [top, bottom] = [seen.top + tool.covered.top, seen.bottom - tool.covered.bottom];
    const inside = tool.at && tool.at[0] > seen.left && tool.at[1] > top && tool.at[0] < seen.right && tool.at[1] < bottom;
    if (!inside) this.#point(tool.towards, { left: seen.left, top, width: seen.width, height: bottom - top });
    else if (tool.radius < large) this.#encircle(tool);
    if (inside && tool.distant && !joinsLabels(tool)) this.#tell(tool.distant);
  }

  #encircle(tool) {
    const { at: [x, y], radius } = tool;
    const r = Math.max(leastRing, radius + 5);
    place(this.ring, { cx: x, cy: y, r });
    this.name.textContent = joinsLabels(tool) ? `Tool, ${tool.distant.text}` : 'Tool';
    place(this.name, { x, y: y - r < nameRoom ? y + r + 15 : y - r - 6 });
  }

  // Places the arrow where a line from the middle towards the tool leaves the view.
  #point([dx, dy], { left, top, width, height }) {
    const [halfX, halfY] = [0.5 * width - margin, 0.5 * height - margin];
    const share = Math.min(halfX / Math.max(Math.abs(dx), 1e-6), halfY / Math.max(Math.abs(dy), 1e-6));
    const [x, y] = [left + 0.5 * width + share * dx, top + 0.5 * height + share * dy];
    const angle = (180 * Math.atan2(dy, dx)) / Math.PI;
    place(this.arrow, { transform: `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${angle.toFixed(1)})` });
    this.name.textContent = 'Tool';
    place(this.name, { x: x - 34 * Math.sign(dx) * (Math.abs(dx) > Math.abs(dy) ? 1 : 0), y: y + (Math.abs(dx) > Math.abs(dy) ? 4 : -22 * Math.sign(dy)) });
  }

  #tell({ text, at }) {
    this.distance.textContent = text;
    place(this.distance, { x: at[0] + 8, y: at[1] });
  }
}

/// Whether the label of the ring says the distance too, since a label of its own would lie on it.
function joinsLabels({ at, radius, distant }) {
  return radius < large && distant && Math.hypot(distant.at[0] - at[0], distant.at[1] - at[1]) < labelRoom;
}

function place(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, typeof value === 'number' ? value.toFixed(1) : value);
  node.classList.remove('unseen');
}
