// The paper's Fig. 5: stacked charts with a common time axis.

import uPlot from 'uplot';

import { element } from '../../shared/dom.js';
import { formatCount } from '../../shared/format.js';
import { themeValue } from '../../shared/theme.js';
import { formatFixed, formatTick } from './format.js';
import { attachGestures } from './gestures.js';
import { overlaySeries } from './overlay.js';
import { linearScale, logScale } from './scales.js';
import { symbol } from './symbol.js';

const axisFont = '11px system-ui, sans-serif';
const valueAxisWidth = 52; // the same for all charts, to align their time axes. Unit: [px].
const timeAxisHeight = 22; // height without its title. Unit: [px].
const timeTitleHeight = 16; // Unit: [px].
const rightPadding = 12; // Unit: [px].
const servoBudget = 1000; // period of a 1 kHz servo loop. Unit: [us].

function forceSeries(run, prefix) {
  return ['x', 'y', 'z'].map((axis) => ({
    name: prefix + axis,
    symbol: ['f', axis],
    values: run.col[prefix + axis],
    color: `--axis-${axis}`,
  }));
}

function chartSpecs(run) {
  const newtons = (v) => formatFixed(v, 3);
  const specs = [
    {
      id: 'counts', title: 'Collision count', unit: 'Gaussians', height: 176, log: true,
      format: formatCount,
      series: [
        ...['candidates', 'filtered', 'colliding'].map((name) => ({
          name, symbol: [name], values: run.col[name], color: `--${name}`,
        })),
        ...overlaySeries(run, 'colliding'),
      ],
    },
    {
      id: 'force', title: 'Repulsive force', unit: 'N, world frame', height: 156, format: newtons,
      series: [
        ...forceSeries(run, 'f'),
        { name: 'force', symbol: ['|F|'], values: run.col.force, color: '--magnitude' },
        ...overlaySeries(run, 'force'),
      ],
    },
  ];
  if (run.hasLive) {
    specs.push({
      id: 'sent', title: 'Force sent', unit: 'N, world frame, after safety limits', height: 130, format: newtons,
      series: [
        ...forceSeries(run, 'sf').map((s) => ({ ...s, symbol: ['s', s.symbol[1]] })),
        { name: 'sent', symbol: ['|S|'], values: run.col.sent, color: '--magnitude' },
        ...overlaySeries(run, 'sent'),
      ],
    });
  }
  if (run.hasTorque) {
    specs.push({
      id: 'torque', title: 'Torque', unit: 'N\u00b7m, world frame', height: 130, format: (v) => formatFixed(v, 4),
      series: forceSeries(run, 't').map((s) => ({ ...s, symbol: ['\u03c4', s.symbol[1]] })),
    });
  }
  if (run.hasUserForce) {
    specs.push({
      id: 'user', title: 'User force', unit: 'N, world frame', height: 130, format: newtons,
      series: forceSeries(run, 'uf').map((s) => ({ ...s, symbol: ['u', s.symbol[1]] })),
    });
  }
  if (run.hasLive) specs.push(...liveSpecs(run));
  specs.push({
    id: 'compute', title: 'Computation time', unit: '\u00b5s', height: 130, log: true,
    format: (v) => formatFixed(v, 1), limit: { value: servoBudget, name: '1 kHz budget' },
    series: [
      { name: 'time', symbol: ['time'], values: run.col.compute_us, color: '--compute' },
      ...(run.hasLive ? [{ name: 'age', symbol: ['age'], values: run.col.age_us, color: '--filtered' }] : []),
      ...overlaySeries(run, 'compute'),
    ],
  });
  return specs;
}

const thousandths = (column) => column.map((v) => (v === null ? null : 1000 * v));

function liveSpecs(run) {
  return [
    {
      id: 'speed', title: 'Speed', unit: 'm/s', height: 100, format: (v) => formatFixed(v, 3),
      series: [{ name: 'speed', symbol: ['speed'], values: run.col.speed, color: '--compute' }],
    },
    {
      id: 'energy', title: 'Energy', unit: 'mJ, net output and stored', height: 110, format: (v) => formatFixed(v, 2),
      series: [
        { name: 'energy', symbol: ['energy'], values: thousandths(run.col.energy), color: '--colliding' },
        { name: 'stored', symbol: ['stored'], values: thousandths(run.col.stored), color: '--filtered' },
      ],
    },
  ];
}

function nameOf({ symbol: [base, subscript], name }) {
  return base === name ? element('span', { text: name }) : symbol(base, subscript);
}

// Legend with name, colour and current value of each series; a click hides or shows the curve.
function buildLegend(spec, toggle) {
  const values = [];
  const items = spec.series.map((series, i) => {
    const chip = element('span', { className: 'chip' });
    chip.style.background = `var(${series.color})`;
    const value = element('span', { className: 'value' });
    values.push(value);
    const button = element('button', {
      className: 'legend-item',
      attributes: { type: 'button', 'aria-pressed': 'true', 'data-series': series.name },
    }, chip, nameOf(series), value);
    button.addEventListener('click', () => {
      const shown = button.getAttribute('aria-pressed') !== 'true';
      button.setAttribute('aria-pressed', String(shown));
      toggle(i, shown);
    });
    return button;
  });
  const update = (row) =>
    spec.series.forEach((series, i) => { values[i].textContent = spec.format(series.values[row]); });
  const limit = element('span', { className: 'legend-limit' }, element('span', { className: 'chip' }), spec.limit?.name ?? '');
  const showLimit = (shown) => { limit.hidden = !shown; };
  showLimit(false);
  return { node: element('div', { className: 'legend' }, limit, ...items), update, showLimit };
}

function axisStyle() {
  return {
    stroke: () => themeValue('--muted'),
    font: axisFont,
    grid: { stroke: () => themeValue('--grid'), width: 1 },
    ticks: { stroke: () => themeValue('--grid'), width: 1, size: 4 },
  };
}

function timeAxis(isLast, label) {
  const common = { ...axisStyle(), space: 70 };
  if (!isLast) return { ...common, size: 8, values: (_, splits) => splits.map(() => '') };
  return {
    ...common, size: timeAxisHeight, gap: 3, values: (_, splits) => splits.map(formatTick),
    label, labelSize: timeTitleHeight, labelGap: 0, labelFont: axisFont,
  };
}

function valueAxis(scale) {
  return {
    ...axisStyle(), size: valueAxisWidth, gap: 4, space: 26, splits: scale.splits,
    filter: (_, splits) => splits, values: (_, splits) => splits.map(scale.label),
  };
}

// Draws contact episodes as bands and onsets as lines, behind the curves.
function drawEpisodes(u, run) {
  const { ctx, bbox } = u;
  const [from, to] = [u.scales.x.min, u.scales.x.max];
  const [band, line] = [themeValue('--contact-band'), themeValue('--onset')];
  ctx.save();
  for (const episode of run.episodes) {
    const end = run.x[episode.last];
    if (end < from || episode.onset > to) continue;
    const left = Math.max(bbox.left, u.valToPos(episode.onset, 'x', true));
    const right = Math.min(bbox.left + bbox.width, u.valToPos(end, 'x', true));
    ctx.fillStyle = band;
    ctx.fillRect(left, bbox.top, Math.max(0, right - left), bbox.height);
    if (episode.onset >= from) {
      ctx.fillStyle = line;
      ctx.fillRect(Math.round(left - 0.5 * uPlot.pxRatio), bbox.top, uPlot.pxRatio, bbox.height);
    }
  }
  ctx.restore();
}

function drawFaults(u, faults) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.fillStyle = themeValue('--fault-line');
  for (const { at } of faults) {
    if (at < u.scales.x.min || at > u.scales.x.max) continue;
    const left = Math.round(u.valToPos(at, 'x', true) - 0.5 * uPlot.pxRatio);
    ctx.fillRect(left, bbox.top, uPlot.pxRatio, bbox.height);
  }
  ctx.restore();
}

// Returns whether the limit is visible.
function drawLimit(u, limit) {
  const { ctx, bbox } = u;
  if (limit < u.scales.y.min || limit > u.scales.y.max) return false;
  const y = Math.round(u.valToPos(limit, 'y', true));
  ctx.save();
  ctx.strokeStyle = themeValue('--limit');
  ctx.lineWidth = 1.5 * uPlot.pxRatio;
  ctx.setLineDash([6 * uPlot.pxRatio, 4 * uPlot.pxRatio]);
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
  return true;
}

const listensToNothing = Object.fromEntries(
  ['mousedown', 'mousemove', 'mouseup', 'mouseenter', 'mouseleave', 'click', 'dblclick']
    .map((name) => [name, () => null]));

function plotOptions(spec, scale, run, timeline, isLast, showLimit) {
  return {
    width: 600,
    height: spec.height + (isLast ? timeAxisHeight + timeTitleHeight : 8),
    padding: [6, rightPadding, 0, 0],
    legend: { show: false },
    // gestures.js moves the cursor, on all charts together and to an exact row.
    cursor: { y: false, bind: listensToNothing, drag: { x: false, y: false, setScale: false },
      dataIdx: () => timeline.row, points: { size: 6 } },
    select: { show: true },
    scales: { x: { time: false, range: () => timeline.range }, y: scale.uplot },
    axes: [timeAxis(isLast, run.timeIsRow ? 'Row' : 'Time (s)'), valueAxis(scale)],
    series: [{}, ...spec.series.map((series) => ({
      label: series.name,
      stroke: () => themeValue(series.color),
      width: series.name === 'force' ? 1 : 1.5,
      points: { show: (u, i, from, to) => to - from < 40, size: 4 },
    }))],
    hooks: {
      drawAxes: [(u) => drawEpisodes(u, run), (u) => drawFaults(u, run.governor?.faults ?? [])],
      draw: [(u) => {
        if (spec.limit) showLimit(drawLimit(u, spec.limit.value));
        placeCursor(u, timeline);
      }],
    },
  };
}

function placeCursor(u, timeline) {
  const time = timeline.x[timeline.row];
  const [min, max] = timeline.range;
  const visible = time >= min && time <= max;
  u.setCursor({ left: visible ? u.valToPos(time, 'x') : -10, top: visible ? 0 : -10 }, false);
}

class Chart {
  constructor(spec, run, timeline, isLast) {
    const scale = spec.log ? logScale(spec.series.map((s) => s.values)) : linearScale();
    const legend = buildLegend(spec, (i, shown) => this.plot.setSeries(i + 1, { show: shown }));
    const heading = element('h3', { text: spec.title }, element('span', { className: 'unit', text: spec.unit }));
    const host = element('div', { className: 'plot' });
    this.id = spec.id;
    this.node = element('section', { className: 'chart', attributes: { 'data-chart': spec.id } },
      element('div', { className: 'chart-head' }, heading, legend.node), host);
    const data = [run.x, ...spec.series.map((s) => scale.toPlot(s.values))];
    this.plot = new uPlot(plotOptions(spec, scale, run, timeline, isLast, legend.showLimit), data, host);
    timeline.onRange(([min, max]) => this.plot.setScale('x', { min, max }));
    timeline.onRow((row) => {
      legend.update(row);
      placeCursor(this.plot, timeline);
    });
    legend.update(timeline.row);
  }

  resize(width) {
    this.plot.setSize({ width, height: this.plot.height });
  }

  select(left, width) {
    this.plot.setSelect({ left, width, top: 0, height: this.plot.over.clientHeight }, false);
  }
}

/// Insets of the plotting area of all charts. Unit: [px].
export const plotInsets = { left: valueAxisWidth, right: rightPadding };

/// Builds the charts in `host` and connects them to the timeline.
export function createCharts(host, run, timeline) {
  const specs = chartSpecs(run);
  const charts = specs.map((spec, i) => new Chart(spec, run, timeline, i === specs.length - 1));
  host.append(...charts.map((chart) => chart.node));
  const select = (left, width) => charts.forEach((chart) => chart.select(left, width));
  charts.forEach((chart) => attachGestures(chart.plot.over, timeline, select));
  const resize = (width) => charts.forEach((chart) => chart.resize(Math.max(200, Math.floor(width))));
  new ResizeObserver(([entry]) => resize(entry.contentRect.width)).observe(host);
  return {
    plots: Object.fromEntries(charts.map((chart) => [chart.id, chart.plot])),
    resize,
    redraw: () => charts.forEach((chart) => chart.plot.redraw(false)),
  };
}
