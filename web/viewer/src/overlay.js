// Marks over the view, in pixels of the page: a ring around a tool that is small, an arrow to one that is out of view,
// and the distance to the surface.

import { svg } from '../../shared/dom.js';

const leastRing = 14; // radius of a ring. Unit: [px].
const large = 26; // a tool of this radius is seen by itself. Unit: [px].
const margin = 30; // of the arrow to the border of the view. Unit: [px].

export class Overlay {
  #key = '';

  constructor(view) {
    this.view = view;
    this.ring = svg('circle', { class: 'tool-ring' });
    this.arrow = svg('path', { class: 'tool-arrow', d: 'M14 0L-6 -9L-2 0L-6 9Z' });
    this.name = svg('text', { class: 'tool-name' }, 'Tool');
    this.distance = svg('text', { class: 'tool-distance' });
    this.node = svg('svg', { class: 'overlay', 'aria-hidden': 'true' }, this.ring, this.arrow, this.name, this.distance);
    view.host.append(this.node);
  }

  /// `tool` is {at: where it is on the page, radius: of it there, distant: text and where, or null}; null hides all.
  show(tool) {
    const key = JSON.stringify(tool);
    if (key === this.#key) return;
    this.#key = key;
    for (const part of this.node.children) part.classList.add('unseen');
    if (!tool) return;
    const { left, top, width, height } = this.view.canvas.getBoundingClientRect();
    const at = tool.at && [tool.at[0] - left, tool.at[1] - top];
    const inside = at && at[0] > 0 && at[1] > 0 && at[0] < width && at[1] < height;
    if (!inside) this.#point(tool.towards, width, height);
    else if (tool.radius < large) this.#encircle(at, tool.radius);
    if (inside && tool.distant) this.#tell(tool.distant, left, top);
  }

  #encircle([x, y], radius) {
    const r = Math.max(leastRing, radius + 5);
    place(this.ring, { cx: x, cy: y, r });
    place(this.name, { x, y: y - r - 6 });
  }

  // Where a line from the middle towards the tool leaves the view.
  #point([dx, dy], width, height) {
    const [halfX, halfY] = [0.5 * width - margin, 0.5 * height - margin];
    const share = Math.min(halfX / Math.max(Math.abs(dx), 1e-6), halfY / Math.max(Math.abs(dy), 1e-6));
    const [x, y] = [0.5 * width + share * dx, 0.5 * height + share * dy];
    const angle = (180 * Math.atan2(dy, dx)) / Math.PI;
    place(this.arrow, { transform: `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${angle.toFixed(1)})` });
    place(this.name, { x: x - 34 * Math.sign(dx) * (Math.abs(dx) > Math.abs(dy) ? 1 : 0), y: y + (Math.abs(dx) > Math.abs(dy) ? 4 : -22 * Math.sign(dy)) });
  }

  #tell({ text, at }, left, top) {
    this.distance.textContent = text;
    place(this.distance, { x: at[0] - left + 8, y: at[1] - top });
  }
}

function place(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, typeof value === 'number' ? value.toFixed(1) : value);
  node.classList.remove('unseen');
}
