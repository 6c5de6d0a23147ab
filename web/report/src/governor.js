// Safety governor of a live run: its state as a coloured strip, and labels of its faults.

import { element } from '../../shared/dom.js';
import { themeValue } from '../../shared/theme.js';
import { plotInsets } from './charts.js';
import { createLabelStrip } from './labels.js';

const stripHeight = 8; // Unit: [px].
const thinnest = 1.5; // least width of a state, so that one of a single tick is visible. Unit: [px].

const stateColor = (name) => themeValue(`--state-${name}`) || themeValue('--muted');

function faultLabel(fault, choose) {
  const node = element('button', {
    className: 'fault', text: fault.name,
    attributes: { type: 'button', 'aria-label': `Zoom to fault ${fault.name}` },
  });
  node.addEventListener('click', () => choose(fault));
  return { at: fault.at, node };
}

/// Legend of the states that occur.
export function governorLegend(governor) {
  const seen = new Set(governor.stretches.map((s) => s.state));
  const items = governor.states.filter((name) => seen.has(name)).map((name) => {
    const chip = element('span', { className: 'chip' });
    chip.style.background = `var(--state-${name}, var(--muted))`;
    return element('span', { className: 'state', attributes: { 'data-state': name } }, chip, name);
  });
  return element('span', { className: 'states' }, 'Safety:', ...items);
}

function paint(canvas, governor, timeline) {
  const ratio = window.devicePixelRatio;
  const width = Math.max(0, canvas.clientWidth);
  [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(stripHeight * ratio)];
  const context = canvas.getContext('2d');
  const [min, max] = timeline.range;
  const toPixel = (time) => (Math.min(Math.max((time - min) / (max - min), 0), 1)) * canvas.width;
  const colors = new Map(governor.states.map((name) => [name, stateColor(name)]));
  for (const { from, to, state } of governor.stretches) {
    if (to < min || from > max) continue;
    const left = toPixel(from);
    context.fillStyle = colors.get(state);
    context.fillRect(left, 0, Math.max(toPixel(to) - left, thinnest * ratio), canvas.height);
  }
}

/// `choose(fault)` is called on a click. Returns a function that updates the layout for a new width or theme; it does
/// nothing for a run that is not live.
export function createGovernorStrip(host, run, timeline, choose) {
  const { governor } = run;
  if (!governor) return () => {};
  const names = element('div', { className: 'faults' });
  const canvas = element('canvas', { attributes: { role: 'img', 'aria-label': 'State of the safety governor over time' } });
  canvas.style.marginLeft = `${plotInsets.left}px`;
  canvas.style.width = `calc(100% - ${plotInsets.left + plotInsets.right}px)`;
  canvas.style.height = `${stripHeight}px`;
  names.hidden = governor.faults.length === 0;
  host.append(names, canvas);
  host.hidden = false;
  const layOutNames = createLabelStrip(names, timeline, governor.faults.map((fault) => faultLabel(fault, choose)));
  const repaint = () => paint(canvas, governor, timeline);
  timeline.onRange(repaint);
  new ResizeObserver(repaint).observe(host);
  return () => {
    layOutNames();
    repaint();
  };
}
