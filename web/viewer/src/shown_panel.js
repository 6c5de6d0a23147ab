// Panel: visibility of the objects in the view.

import { byId, element } from '../../shared/dom.js';
import { formatCount } from '../../shared/format.js';
import { checkbox, hint } from './fields.js';

/// Returns {shown, update()}; `shown` has a flag per object. `changed` is called after every change.
export function createShownPanel({ splats, felt, changed }) {
  const shown = { contacts: true, normals: true, force: true, torque: true, proxy: true };
  const toggles = Object.entries({ contacts: 'Contacts', normals: 'Normals', force: 'Force', torque: 'Torque', proxy: 'Proxy' })
    .map(([name, label]) => checkbox({ label, name }, (on) => {
      shown[name] = on;
      changed();
    }));
  const scene = checkbox({ label: 'What the eye sees', name: 'scene' }, (on) => splats.showScene(on));
  const hand = checkbox({ label: 'What the hand can feel', name: 'felt', checked: false }, (on) => {
    splats.showFelt(on);
    changed();
  });
  const byDepth = checkbox({ label: 'Colour contacts by depth, not by K', name: 'by-depth', checked: false }, (on) => {
    felt.colorBy = on ? 'depth' : 'k_min';
    changed();
  });
  byDepth.lastChild.append(element('sub', { text: 'min' }));
  const count = hint('');
  byId('shown').append(scene, hand, count, element('div', { className: 'toggles' }, ...toggles), byDepth);
  const update = () => {
    const { feltCount, keptCount } = splats;
    count.hidden = feltCount === 0;
    const text = feltCount < keptCount
      ? `The ${formatCount(feltCount)} nearest to the tool of ${formatCount(keptCount)} ellipsoids are drawn.`
      : `All ${formatCount(keptCount)} ellipsoids are drawn.`;
    if (!count.hidden && count.textContent !== text) count.textContent = text;
  };
  return { shown, update };
}
