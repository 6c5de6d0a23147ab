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
  const scene = checkbox({ label: 'Captured splats', name: 'scene' }, (on) => splats.showScene(on));
  const hand = checkbox({ label: 'Touchable ellipsoids', name: 'felt', checked: false }, (on) => {
    splats.showFelt(on);
    changed();
  });
  const byDepth = checkbox({ label: 'Colour contacts by depth, not K', name: 'by-depth', checked: false }, (on) => {
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
      ? `Showing the ${formatCount(feltCount)} of ${formatCount(keptCount)} ellipsoids nearest to the tool.`
      : `Showing all ${formatCount(keptCount)} ellipsoids.`;
    if (!count.hidden && count.textContent !== text) count.textContent = text;
  };
  return { shown, update };
}
