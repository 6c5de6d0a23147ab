// Reads the run from the page and builds the report.

import { byId, element } from '../../shared/dom.js';
import { formatCount } from '../../shared/format.js';
import { followTheme } from '../../shared/theme.js';
import { createCharts } from './charts.js';
import { parseRun } from './data.js';
import { formatFixed } from './format.js';
import { attachKeys } from './gestures.js';
import { createGovernorStrip, governorLegend } from './governor.js';
import { createOnsetStrip } from './onsets.js';
import { createRunsTable } from './overlay.js';
import { createTable } from './table.js';
import { Timeline } from './timeline.js';
import { createView } from './view3d.js';

const contactMargin = 0.35; // range shown before and after a contact, as a fraction of its duration
const smallestMargin = 0.005; // least margin, for contacts of one or two rows; as a fraction of the run's duration
const faultMargin = 0.5; // range shown before and after a fault. Unit: [s], or rows if the axis has row numbers.
const printWidth = 660; // fits portrait A4 and Letter. Unit: [px].

function showNotice(text) {
  const notice = byId('notice');
  notice.textContent = text;
  notice.hidden = false;
}

function readRun() {
  const text = byId('run').textContent.trim();
  if (text.startsWith('<')) {
    showNotice('This page contains no run: it is the template of palpate report.');
    return null;
  }
  try {
    return parseRun(text);
  } catch (error) {
    showNotice(`The run in this page cannot be read: ${error.message}`);
    return null;
  }
}

function showHeader(run) {
  byId('title').textContent = run.title;
  byId('generator').textContent = run.generator;
  const made = [run, ...run.others].filter((one) => one.made !== '');
  byId('made').hidden = made.length === 0;
  byId('made').querySelector('pre').textContent =
    made.map((one) => (run.others.length > 0 ? `# ${one.title}\n${one.made}` : one.made)).join('\n');
  byId('summary').append(...run.summary.map(({ label, value }) =>
    element('div', {}, element('dt', { text: label }), element('dd', { text: value }))));
}

function showInstant(run, row) {
  const parts = [`row ${formatCount(row)}`];
  if (!run.timeIsRow) parts.unshift(`t = ${formatFixed(run.x[row], 3)} s`);
  const state = run.governor?.states[run.col.state[row]];
  if (state) parts.push(state);
  byId('instant').replaceChildren(...parts.map((text) => element('span', { text })));
}

function showHints(run) {
  const notes = [];
  if (run.episodes.length > 0) notes.push('Shaded: in contact.');
  if (run.governor?.faults.length > 0) notes.push('Labelled lines: faults.');
  if (run.timeIsRow) notes.push('The times are incomplete or not in order: the axis shows row numbers instead.');
  byId('bands-hint').append(notes.join(' '), ...(run.governor ? [governorLegend(run.governor)] : []));
}

function contactRange(run, timeline, episode) {
  const end = run.x[episode.last];
  const length = timeline.full[1] - timeline.full[0];
  const margin = Math.max(contactMargin * (end - episode.onset), smallestMargin * length);
  return [episode.onset - margin, end + margin];
}

// Redraws the canvases in the light theme at the width of paper before printing.
function followPrinting(charts, layOut, redraw) {
  const fit = (theme, width) => {
    document.documentElement.dataset.theme = theme;
    for (const id of ['charts', 'onsets', 'governor']) byId(id).style.width = width ? `${width}px` : '';
    charts.resize(byId('charts').clientWidth);
    layOut();
    redraw();
  };
  window.addEventListener('beforeprint', () => {
    byId('made').open = true; // closed details are not printed
    fit('light', printWidth);
  });
  window.addEventListener('afterprint', () => fit('', null));
}

function showReport(run) {
  byId('report').hidden = false;
  const timeline = new Timeline(run.x);
  const charts = createCharts(byId('charts'), run, timeline);
  const view = createView({ host: byId('view'), controls: byId('view-controls'), reset: byId('reset-view') }, run);

  const choose = (index) => {
    const episode = run.episodes[index];
    timeline.setRange(...contactRange(run, timeline, episode));
    timeline.setRow(episode.peak);
    markRow(index);
  };
  const markRow = createTable(byId('contacts'), run, choose);
  const layOutOnsets = createOnsetStrip(byId('onsets'), run, timeline, choose);
  const layOutGovernor = createGovernorStrip(byId('governor'), run, timeline, (fault) => {
    timeline.setRange(fault.at - faultMargin, fault.at + faultMargin);
    timeline.setRow(fault.row);
  });
  attachKeys(byId('charts'), timeline);
  byId('runs-card').hidden = run.others.length === 0;
  if (run.others.length > 0) createRunsTable(byId('runs'), run);

  byId('reset-zoom').addEventListener('click', () => timeline.reset());
  timeline.onRange(() => {
    byId('reset-zoom').disabled = !timeline.isZoomed;
    if (!timeline.isZoomed) markRow(null);
  });
  timeline.onRow((row) => {
    showInstant(run, row);
    view.setMarker(row);
  });
  timeline.setRow(run.episodes[0]?.peak ?? 0);
  showHints(run);

  const redraw = () => {
    charts.redraw();
    layOutGovernor();
    view.redraw();
  };
  followTheme(redraw);
  followPrinting(charts, layOutOnsets, redraw);
  return { run, timeline, plots: charts.plots, view };
}

const run = readRun();
if (run) {
  showHeader(run);
  if (run.rows > 0) window.palpateReport = showReport(run); // for tests and the console
  else showNotice('The run has no rows.');
}
