// Display of the proposals of `palpate setup` for an unknown scene, with a button to apply them.

import { element } from '../../shared/dom.js';
import { button, hint } from './fields.js';

const names = { frame: 'Up axis', scale: 'Scale', opacity_min: 'Opacity cut', max_scale: 'Largest Gaussian', crop_box: 'Crop' };
const placed = ['frame', 'scale']; // parts of the registration; the others are parts of the filter

const shown = (value) => (Array.isArray(value) ? value.map((v) => Number(v.toPrecision(3))).join(', ')
  : typeof value === 'number' ? String(Number(value.toPrecision(3))) : value);

/// Changes of parameters for a proposal. Parameters without a proposed value do not change.
export function changesOf(proposal) {
  const wanted = (isPlaced) => Object.fromEntries(Object.entries(proposal)
    .filter(([name, { value }]) => value !== null && placed.includes(name) === isPlaced).map(([name, { value }]) => [name, value]));
  return { registration: wanted(true), filter: wanted(false) };
}

/// `propose` resolves to the proposal as JSON, or null; `apply` receives changes of parameters.
export function createSetup({ propose, apply }) {
  const list = element('dl', { className: 'help' });
  const take = button('Apply', () => {
    apply(changesOf(proposal));
    show(null);
  }, { name: 'take-setup' });
  const dismiss = button('Dismiss', () => show(null), { name: 'leave-setup' });
  const box = element('div', { className: 'setup' }, list, element('div', { className: 'buttons' }, take, dismiss));
  const said = hint('');
  said.setAttribute('role', 'status');
  let proposal = null;
  const show = (what) => {
    proposal = what;
    box.hidden = !what;
    list.replaceChildren(...Object.entries(what ?? {}).flatMap(([name, { value, reason }]) => [
      element('dt', { text: `${names[name] ?? name}: ${value === null ? 'unchanged' : shown(value)}` }), element('dd', { text: `${reason}.` })]));
  };
  const ask = button('Propose a setup', async () => {
    said.textContent = 'Reading the scene…';
    const text = await propose();
    said.textContent = '';
    show(text === null ? null : JSON.parse(text));
  }, { name: 'propose-setup' });
  show(null);
  return element('div', { className: 'fields' }, ask, said, box);
}
