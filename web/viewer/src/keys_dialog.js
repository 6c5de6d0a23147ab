// Dialog that lists the functions of mouse, touch and keys.

import { byId } from '../../shared/dom.js';
import { cancelledByEscape } from './escape.js';

/// Returns a function that opens the dialog.
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
    forget(); // not only on the close event: the next Escape must stop the force
    dialog.close();
  });
  return open;
}
