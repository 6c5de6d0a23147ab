// Table of the contacts, one row per onset.

import { element } from '../../shared/dom.js';
import { formatCount } from '../../shared/format.js';
import { formatFixed } from './format.js';
import { symbol } from './symbol.js';

const millimetres = 1000; // per metre

function columnsFor(run) {
  const columns = [
    { title: 'Onset', unit: run.timeIsRow ? 'row' : 's', text: (e) => formatFixed(e.onset, run.timeIsRow ? 0 : 3) },
    { title: 'Duration', unit: 's', text: (e) => formatFixed(e.duration, 3) },
    { title: 'Position', unit: 'm', className: 'position',
      text: (e) => (e.position ? e.position.map((v) => formatFixed(v, 3)).join(', ') : formatFixed(null)) },
    { title: 'Peak colliding', unit: '', text: (e) => formatCount(e.peakColliding) },
    { title: 'Peak force', unit: 'N', text: (e) => formatFixed(e.peakForce, 3) },
  ];
  if (run.episodes.some((e) => e.maxDepth !== null)) {
    columns.push({ title: 'Max depth', unit: 'mm',
      text: (e) => formatFixed(e.maxDepth === null ? null : millimetres * e.maxDepth, 2) });
  }
  return columns;
}

function headCell({ title, unit, className }) {
  const cell = element('th', { className, text: title, attributes: { scope: 'col', role: 'columnheader' } });
  if (unit) cell.append(' ', element('span', { className: 'unit', text: unit }));
  return cell;
}

function bodyRow(episode, columns, choose) {
  const button = element('button', {
    className: 'contact-label',
    attributes: { type: 'button', 'aria-label': `Zoom to contact t ${episode.subscript}` },
  }, symbol('t', episode.subscript));
  const head = element('th', { attributes: { scope: 'row', role: 'rowheader' } }, button);
  // On a phone, rows are shown as cards in which each value has its title and unit.
  const cells = columns.map((c) => element('td', {
    className: c.className,
    text: c.text(episode),
    attributes: { role: 'cell', 'data-title': c.unit ? `${c.title} (${c.unit})` : c.title },
  }));
  const row = element('tr', { attributes: { role: 'row' } }, head, ...cells);
  row.addEventListener('click', choose);
  return row;
}

/// `choose(episode index)` is called when a row is activated by click or key. Returns a function that marks one row as
/// current, or none for null.
export function createTable(host, run, choose) {
  if (run.episodes.length === 0) {
    host.append(element('p', { className: 'empty', text: 'The tool touched nothing in this run.' }));
    return () => {};
  }
  const columns = columnsFor(run);
  const rows = run.episodes.map((episode, i) => bodyRow(episode, columns, () => choose(i)));
  const corner = headCell({ title: 'Contact', unit: '' });
  // The roles are explicit because the card layout of phones removes the implicit ones.
  const head = element('tr', { attributes: { role: 'row' } }, corner, ...columns.map(headCell));
  host.append(element('div', { className: 'table-scroll' },
    element('table', { attributes: { role: 'table', 'aria-labelledby': 'contacts-title' } },
      element('thead', { attributes: { role: 'rowgroup' } }, head),
      element('tbody', { attributes: { role: 'rowgroup' } }, ...rows))));
  return (chosen) => rows.forEach((row, i) => {
    if (i === chosen) row.setAttribute('aria-current', 'true');
    else row.removeAttribute('aria-current');
  });
}
