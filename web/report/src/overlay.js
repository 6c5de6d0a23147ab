// Further runs plotted over the first, resampled at its times. Each run has its own clock.

import { element } from '../../shared/dom.js';

const colors = 3; // --run-1 ... --run-3

// Nearest of `values` at sorted `times` for each of the sorted `x`; null before the first and after the last time.
function resampled(x, times, values) {
  let next = 0;
  return x.map((at) => {
    if (times.length === 0 || at < times[0] || at > times.at(-1)) return null;
    while (next + 1 < times.length && times[next + 1] <= at) ++next;
    const later = next + 1 < times.length && times[next + 1] - at < at - times[next];
    return values[later ? next + 1 : next];
  });
}

/// Parses the further runs; `x` are the times of the first run. `columnsOf` parses columns like those of the first.
export function parseOthers(list, x, columnsOf) {
  return (Array.isArray(list) ? list : []).map((json, i) => {
    const { col, rows } = columnsOf(json?.columns);
    const inOrder = col.t.every((t, k) => t !== null && (k === 0 || t >= col.t[k - 1]));
    const times = inOrder ? col.t : Array.from({ length: rows }, (_, k) => k);
    const at = (values) => (values ? resampled(x, times, values) : null);
    return {
      title: typeof json?.title === 'string' ? json.title : `Run ${i + 2}`,
      made: typeof json?.made === 'string' ? json.made : '',
      summary: Array.isArray(json?.summary) ? json.summary : [],
      color: `--run-${(i % colors) + 1}`,
      colliding: at(col.colliding), force: at(col.force), sent: at(col.sent), compute: at(col.compute_us),
    };
  });
}

/// Series of the further runs in the chart of `what`.
export function overlaySeries(run, what) {
  const isDrawn = (other) => other[what]?.some((value) => value !== null);
  return run.others.filter(isDrawn).map((other) => ({
    name: other.title, symbol: [other.title], values: other[what], color: other.color,
  }));
}

/// Table of the summaries of all runs, side by side.
export function createRunsTable(host, run) {
  const all = [run, ...run.others];
  const labels = [...new Set(all.flatMap(({ summary }) => summary.map(({ label }) => label)))];
  const valueOf = ({ summary }, label) => summary.find((item) => item.label === label)?.value ?? '\u2013';
  const head = element('tr', {}, element('th', { text: '' }), ...all.map(({ title }) => element('th', { text: title, attributes: { scope: 'col' } })));
  const rows = labels.map((label) => element('tr', {},
    element('th', { text: label, attributes: { scope: 'row' } }), ...all.map((one) => element('td', { text: valueOf(one, label) }))));
  host.append(element('div', { className: 'table-scroll' },
    element('table', { attributes: { 'aria-labelledby': 'runs-title' } }, element('thead', {}, head), element('tbody', {}, ...rows))));
}
