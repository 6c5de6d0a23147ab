// Labels at instants, above the charts.

import { plotInsets } from './charts.js';

const labelGap = 4; // Unit: [px].

/// Puts `labels`, of the form {at, node} and in order of time, into `host`, each over its time. Returns a function
/// that lays them out anew.
export function createLabelStrip(host, timeline, labels) {
  host.append(...labels.map(({ node }) => node));
  let widths = null;

  // Where labels crowd, the first of them stays.
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
