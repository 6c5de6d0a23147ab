// The Escape key: cancels the newest open dialog or pending action; if there is none, it stops the force.

const open = [];

/// Registers `cancel`, which Escape calls once, before those registered earlier. Returns a function to unregister it.
export function cancelledByEscape(cancel) {
  open.push(cancel);
  return () => {
    const at = open.indexOf(cancel);
    if (at >= 0) open.splice(at, 1);
  };
}

export function followEscape(stop) {
  window.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' || event.repeat) return;
    const cancel = open.pop();
    if (!cancel) {
      stop();
      return;
    }
    event.preventDefault();
    cancel();
  }, { capture: true });
}
