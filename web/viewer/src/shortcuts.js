// Keyboard shortcuts of the page, inactive in text fields.

const isTyping = (node) => node instanceof HTMLElement && node.matches('input:not([type=checkbox], [type=range]), select, textarea');

/// Whether a dialog is open, to which the keys then belong.
export const isDialogOpen = () => document.querySelector('dialog[open]') !== null;

/// `actions` are functions by key. Key repeats are ignored.
export function followShortcuts(actions) {
  window.addEventListener('keydown', (event) => {
    const { key, repeat, ctrlKey, metaKey, altKey, target } = event;
    const action = actions[key.toLowerCase()];
    if (!action || repeat || ctrlKey || metaKey || altKey || isTyping(target) || isDialogOpen()) return;
    event.preventDefault();
    action();
  });
}
