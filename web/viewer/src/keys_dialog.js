// The list of what mouse, touch and keys do.

import { byId } from '../../shared/dom.js';
import { cancelledByEscape } from './escape.js';

/// Returns what opens it.
export function createKeysDialog() {
  const dialog = byId('keys');
  let forget = () => {};
  const open = () => {
    if (dialog.open) return;
    dialog.showModal();
    forget = cancelledByEscape(() => dialog.close());
  };
  dialog.addEventListener('close', () => forget());
  byId('show-keys').addEventListener('click', open);
  byId('keys-close').addEventListener('click', () => {
    forget(); // at once: the next Escape stops
    dialog.close();
  });
  return open;
}
