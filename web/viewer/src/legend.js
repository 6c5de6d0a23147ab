// Legend: scale bars of length and force, and the colours of contacts.

import { byId, element, svg } from '../../shared/dom.js';
import { niceFloor } from '../../shared/format.js';
import { formatFixed, formatLength } from './format.js';
import { rampColors } from './ramp.js';

const longest = 110; // largest length of a bar. Unit: [px].

function bar(className) {
  const line = svg('svg', { class: `scale-bar ${className}` }, svg('path'));
  const text = element('span');
  return { node: element('div', { className: 'scale-row' }, line, text), line, text };
}

function setBar({ line, text }, pixels, said) {
  line.setAttribute('width', Math.ceil(pixels) + 2);
  line.setAttribute('height', 8);
  line.firstChild.setAttribute('d', `M1 1v6M1 4H${(pixels + 1).toFixed(1)}M${(pixels + 1).toFixed(1)} 1v6`);
  text.textContent = said;
}

function handRow({ name, color, force }) {
  const fill = `rgb(${color.map((c) => Math.round(255 * c)).join()})`;
  const swatch = svg('svg', { class: 'swatch', width: 10, height: 10 }, svg('circle', { cx: 5, cy: 5, r: 5, fill }));
  return element('div', { className: 'scale-row' }, swatch, element('span', { text: `${name || 'first hand'} ${formatFixed(force, 1)} N` }));
}

// SVG gradient: the page's policy forbids the inline style of a CSS gradient.
function rampBar() {
  const stops = rampColors.map((color, i) => svg('stop', { offset: i / (rampColors.length - 1), 'stop-color': color }));
  return svg('svg', { class: 'ramp', viewBox: '0 0 24 1', preserveAspectRatio: 'none' },
    svg('linearGradient', { id: 'ramp-colors' }, ...stops), svg('rect', { width: 24, height: 1, fill: 'url(#ramp-colors)' }));
}

export class Legend {
  constructor(view, felt) {
    Object.assign(this, { view, felt });
    this.length = bar('length');
    this.force = bar('force');
    this.from = element('span');
    this.to = element('span');
    this.hands = element('div');
    byId('legend').append(this.length.node, this.force.node, element('div', { className: 'scale-row' }, this.from, rampBar(), this.to), this.hands);
  }

  /// Shows a line per other hand: its colour, name and force.
  showHands(others) {
    const key = JSON.stringify(others.map(({ name, force }) => [name, formatFixed(force, 1)]));
    if (key === this.shownHands) return;
    this.shownHands = key;
    this.hands.replaceChildren(...others.map(handRow));
  }

  update() {
    const pixel = this.view.pixelAt(this.view.orbit.target.toArray());
    const { forceLength, colorBy, deepest } = this.felt;
    const key = [pixel, forceLength, colorBy, deepest].join();
    if (key === this.key) return;
    this.key = key;
    const length = niceFloor(longest * pixel);
    setBar(this.length, length / pixel, formatLength(length));
    const newtons = niceFloor((longest * pixel) / forceLength);
    setBar(this.force, (newtons * forceLength) / pixel, `${newtons} N`);
    this.from.textContent = colorBy === 'depth' ? '0' : 'touching';
    this.to.textContent = colorBy === 'depth' ? `${formatFixed(1000 * (deepest ?? 0), 1)} mm deep` : 'deep';
  }
}
