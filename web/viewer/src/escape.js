// The Escape key: it cancels what is open or going on, the newest first; where nothing is, it stops the force.

const open = [];

/// Has Escape call `cancel` once, before what was there. Returns what takes that back.
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
