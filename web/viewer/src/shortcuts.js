// Keys of the page, which work wherever nothing is typed.

const isTyping = (node) => node instanceof HTMLElement && node.matches('input:not([type=checkbox], [type=range]), select, textarea');

/// `actions` by key. A key that is held down counts once.
export function followShortcuts(actions) {
  window.addEventListener('keydown', (event) => {
    const { key, repeat, ctrlKey, metaKey, altKey, target } = event;
    const action = actions[key.toLowerCase()];
    if (!action || repeat || ctrlKey || metaKey || altKey || isTyping(target) || document.querySelector('dialog[open]')) return;
    event.preventDefault();
    action();
  });
}
