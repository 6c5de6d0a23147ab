// Clicks and taps on the view: presses without motion.

const room = { mouse: 5, pen: 5, touch: 12 }; // a press with more motion is a drag. Unit: [px].

/// Calls `onClick` for a click of the main button or a tap of one finger.
export function followClicks(canvas, onClick) {
  let down = null;
  let fingers = 0;
  const isStill = (event) => Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) <= (room[event.pointerType] ?? room.mouse);
  canvas.addEventListener('pointerdown', (event) => {
    fingers = event.isPrimary ? 1 : fingers + 1;
    down = event.isPrimary && event.button === 0 ? event : null;
  });
  canvas.addEventListener('pointerup', (event) => {
    if (down && event.isPrimary && fingers === 1 && isStill(event)) onClick(event);
    if (event.isPrimary) down = null;
  });
  canvas.addEventListener('pointercancel', () => { down = null; });
}
