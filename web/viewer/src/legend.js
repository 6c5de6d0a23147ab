// How long a length and a force are drawn, and what the colours of contacts mean.

import { byId, element } from './dom.js';
import { formatFixed, formatLength, niceFloor } from './format.js';
import { rampColors } from './ramp.js';

const longest = 110; // of a bar. Unit: [px].
const svgNamespace = 'http://www.w3.org/2000/svg';

function bar(className) {
  const line = document.createElementNS(svgNamespace, 'svg');
  line.setAttribute('class', `scale-bar ${className}`);
  line.append(document.createElementNS(svgNamespace, 'path'));
  const text = element('span');
  return { node: element('div', { className: 'scale-row' }, line, text), line, text };
}

function setBar({ line, text }, pixels, said) {
  line.setAttribute('width', Math.ceil(pixels) + 2);
  line.setAttribute('height', 8);
  line.firstChild.setAttribute('d', `M1 1v6M1 4H${(pixels + 1).toFixed(1)}M${(pixels + 1).toFixed(1)} 1v6`);
  text.textContent = said;
}

// A gradient in an SVG needs no inline style, which the page's policy forbids.
function rampBar() {
  const image = document.createElementNS(svgNamespace, 'svg');
  image.setAttribute('class', 'ramp');
  const steps = 24;
  image.setAttribute('viewBox', `0 0 ${steps} 1`);
  image.setAttribute('preserveAspectRatio', 'none');
  const defs = document.createElementNS(svgNamespace, 'linearGradient');
  defs.id = 'ramp-colors';
  rampColors.forEach((color, i) => {
    const stop = document.createElementNS(svgNamespace, 'stop');
    stop.setAttribute('offset', i / (rampColors.length - 1));
    stop.setAttribute('stop-color', color);
    defs.append(stop);
  });
  const fill = document.createElementNS(svgNamespace, 'rect');
  for (const [name, value] of Object.entries({ width: steps, height: 1, fill: 'url(#ramp-colors)' })) fill.setAttribute(name, value);
  image.append(defs, fill);
  return image;
}

export class Legend {
  constructor(view, felt) {
    Object.assign(this, { view, felt });
    this.length = bar('length');
    this.force = bar('force');
    this.from = element('span');
    this.to = element('span');
    byId('legend').append(this.length.node, this.force.node, element('div', { className: 'scale-row' }, this.from, rampBar(), this.to));
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
