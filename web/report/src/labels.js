// Labels at points in time, above the charts.

import { plotInsets } from './charts.js';

const labelGap = 4; // Unit: [px].

/// Adds `labels` {at, node}, sorted by time, to `host`, each above its time. Returns a function to update the layout.
export function createLabelStrip(host, timeline, labels) {
  host.append(...labels.map(({ node }) => node));
  let widths = null;

  // Of overlapping labels, the first is shown.
  function layOut() {
    widths ??= labels.map(({ node }) => node.offsetWidth);
    const [min, max] = timeline.range;
    const span = host.clientWidth - plotInsets.left - plotInsets.right;
    let taken = -Infinity;
    labels.forEach(({ at, node }, i) => {
      const centre = plotInsets.left + ((at - min) / (max - min)) * span;
      const left = Math.min(centre - 0.5 * widths[i], host.clientWidth - widths[i]);
      const shown = at >= min && at <= max && left >= taken;
      node.style.visibility = shown ? 'visible' : 'hidden';
      node.style.left = `${shown ? left : 0}px`;
      if (shown) taken = left + widths[i] + labelGap;
    });
  }

  timeline.onRange(layOut);
  new ResizeObserver(layOut).observe(host);
  return layOut;
}
