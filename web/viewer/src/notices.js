// Temporary notices: refusals and messages of the program.

import { byId, element } from '../../shared/dom.js';

const shownFor = 8000; // duration of a notice. Unit: [ms].
const most = 3;

/// Shows `text` as a notice; a repeated text extends the existing notice.
export function notify(text, kind = 'refusal') {
  const host = byId('notices');
  const same = [...host.children].find((node) => node.dataset.text === text);
  const node = same ?? element('div', { className: `card notice ${kind}` }, element('span', { text }));
  if (!same) {
    node.dataset.text = text;
    const close = element('button', { text: '×', attributes: { type: 'button', 'aria-label': 'Dismiss' } });
    close.addEventListener('click', () => node.remove());
    node.append(close);
    host.append(node);
    while (host.children.length > most) host.firstChild.remove();
  }
  clearTimeout(node.timer);
  node.timer = setTimeout(() => node.remove(), shownFor);
}
