// Labels t_a, t_b, ... above the charts, each above the line of its onset.

import { element } from '../../shared/dom.js';
import { createLabelStrip } from './labels.js';
import { symbol } from './symbol.js';

/// `choose(episode index)` is called on a click. Returns a function that updates the layout.
export function createOnsetStrip(host, run, timeline, choose) {
  // The table has the same buttons, so the labels are not in the tab order.
  const labels = run.episodes.map((episode, index) => {
    const node = element('button', {
      className: 'onset',
      attributes: { type: 'button', tabindex: '-1', 'data-onset': episode.subscript,
        'aria-label': `Zoom to contact t ${episode.subscript}` },
    }, symbol('t', episode.subscript));
    node.addEventListener('click', () => choose(index));
    return { at: episode.onset, node };
  });
  return createLabelStrip(host, timeline, labels);
}
