// Blocks a page whose address names a hand that the program does not have: nothing on it would work, not even its stop button.

import { byId, element } from '../../shared/dom.js';
import { ownHand } from './address.js';

const pageOf = (hand) => element('li', {}, element('a', {
  text: hand || 'the first hand', attributes: { href: hand ? `?hand=${hand}` : location.pathname },
}));

/// Call before the connection is opened.
export function refuseUnknownHand(connection) {
  if (!ownHand) return;
  connection.subscribe('/palpate/parameters', 'std_msgs/String', ({ data }) => {
    const { hands } = JSON.parse(data);
    const isUnknown = !hands.includes(ownHand);
    document.body.classList.toggle('unknown-hand', isUnknown);
    byId('unknown-hand').replaceChildren(
      element('p', { text: `This program has no hand “${ownHand}”. Its hands are:` }), element('ul', {}, ...['', ...hands].map(pageOf)));
    byId('unknown-hand').hidden = !isUnknown;
  });
}
