// The labels t_a, t_b, ... above the charts, each over the line of its onset.

import { plotInsets } from './charts.js';
import { element, symbol } from './dom.js';

const labelGap = 4; // Unit: [px].

/// `choose(episode index)` is called on a click. Returns a function that lays the labels out anew.
export function createOnsetStrip(host, run, timeline, choose) {
  // The table offers the same by keyboard, so the labels stay out of the tab order.
  const labels = run.episodes.map((episode, index) => {
    const label = element('button', {
      className: 'onset',
      attributes: { type: 'button', tabindex: '-1', 'data-onset': episode.subscript,
        'aria-label': `Zoom to contact t ${episode.subscript}` },
    }, symbol('t', episode.subscript));
    label.addEventListener('click', () => choose(index));
    return label;
  });
  host.append(...labels);
  let widths = null;

  // Where onsets crowd, the first of them keeps its label.
  function layOut() {
    widths ??= labels.map((label) => label.offsetWidth);
    const [min, max] = timeline.range;
    const span = host.clientWidth - plotInsets.left - plotInsets.right;
    let taken = -Infinity;
    labels.forEach((label, i) => {
      const { onset } = run.episodes[i];
      const centre = plotInsets.left + ((onset - min) / (max - min)) * span;
      const left = Math.min(centre - 0.5 * widths[i], host.clientWidth - widths[i]);
      const shown = onset >= min && onset <= max && left >= taken;
      label.style.visibility = shown ? 'visible' : 'hidden';
      label.style.left = `${shown ? left : 0}px`;
      if (shown) taken = left + widths[i] + labelGap;
    });
  }

  timeline.onRange(layOut);
  new ResizeObserver(layOut).observe(host);
  return layOut;
}
