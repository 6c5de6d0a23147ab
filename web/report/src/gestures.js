// Pointer gestures on a chart: hover to read, drag to zoom, Shift-drag to move, double-click to reset; by touch, slide
// to read and pinch to zoom. Keys do the same.

const smallestDrag = 4; // shorter drags are clicks. Unit: [px].
const keyZoom = 0.5;
const keyBigStep = 0.02; // fraction of the visible range

function timeAt(timeline, fraction) {
  const [min, max] = timeline.range;
  return min + Math.min(Math.max(fraction, 0), 1) * (max - min);
}

/// `over` is the plotting area of one chart; `select(left, width)` marks a range on all charts.
export function attachGestures(over, timeline, select) {
  const fingers = new Map(); // pointer id to x. Unit: [px].
  let drag = null;

  const xOf = (event) => event.clientX - over.getBoundingClientRect().left;
  const fractionAt = (x) => x / over.clientWidth;
  const hover = (x) => timeline.setRow(timeline.nearestRow(timeAt(timeline, fractionAt(x))));

  function startDrag(event) {
    if (event.button !== 0) return;
    over.setPointerCapture(event.pointerId);
    drag = { from: xOf(event), to: xOf(event), pans: event.shiftKey };
  }

  function moveDrag(event) {
    const x = Math.min(Math.max(xOf(event), 0), over.clientWidth);
    if (drag.pans) {
      const [min, max] = timeline.range;
      timeline.pan(((drag.to - x) / over.clientWidth) * (max - min));
    } else {
      select(Math.min(drag.from, x), Math.abs(x - drag.from));
    }
    drag.to = x;
  }

  function endDrag() {
    const { from, to, pans } = drag;
    drag = null;
    select(0, 0);
    if (pans || Math.abs(to - from) < smallestDrag) return;
    const [a, b] = [from, to].map((x) => timeAt(timeline, fractionAt(x))).sort((p, q) => p - q);
    timeline.setRange(a, b);
  }

  function pinch(event) {
    const before = [...fingers.values()];
    fingers.set(event.pointerId, xOf(event));
    const after = [...fingers.values()];
    const spread = ([a, b]) => Math.max(Math.abs(a - b), 1);
    const centre = timeAt(timeline, fractionAt(0.5 * (after[0] + after[1])));
    timeline.zoom(spread(before) / spread(after), centre);
  }

  over.addEventListener('pointerdown', (event) => {
    if (event.pointerType !== 'touch') {
      startDrag(event);
      return;
    }
    fingers.set(event.pointerId, xOf(event));
    if (fingers.size === 1) hover(xOf(event));
  });

  over.addEventListener('pointermove', (event) => {
    if (event.pointerType === 'touch') {
      if (fingers.size === 2) pinch(event);
      else hover(xOf(event));
      return;
    }
    if (drag) moveDrag(event);
    hover(xOf(event));
  });

  for (const name of ['pointerup', 'pointercancel']) {
    over.addEventListener(name, (event) => {
      fingers.delete(event.pointerId);
      if (drag && name === 'pointerup') endDrag();
      else if (drag) { drag = null; select(0, 0); }
    });
  }

  over.addEventListener('dblclick', () => timeline.reset());
}

/// Arrow keys step through the rows, + and - zoom about the current row, Escape resets.
export function attachKeys(node, timeline) {
  const step = (rows) => timeline.setRow(timeline.row + rows);
  const jump = (sign) => {
    const [min, max] = timeline.range;
    const target = timeline.nearestRow(timeline.x[timeline.row] + sign * keyBigStep * (max - min));
    timeline.setRow(target === timeline.row ? target + sign : target);
  };
  const zoom = (factor) => timeline.zoom(factor, timeline.x[timeline.row]);
  const actions = {
    ArrowLeft: (event) => (event.shiftKey ? jump(-1) : step(-1)),
    ArrowRight: (event) => (event.shiftKey ? jump(1) : step(1)),
    '+': () => zoom(keyZoom),
    '=': () => zoom(keyZoom),
    '-': () => zoom(1 / keyZoom),
    Escape: () => timeline.reset(),
  };
  node.addEventListener('keydown', (event) => {
    const action = actions[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action(event);
  });
}
