// Plots of the last seconds of the diagnostics.

import uPlot from 'uplot';

import { byId, element } from '../../shared/dom.js';
import { isNumber, niceFloor } from '../../shared/format.js';
import { followTheme, themeValue } from '../../shared/theme.js';
import { formatFixed } from './format.js';

const span = 20; // displayed time. Unit: [s].
const height = 64; // of a plot. Unit: [px].
const redrawEvery = 100; // Unit: [ms].
const manyDigits = 100; // value from which on no decimals are shown, so that two values fit a line

// `least` is the smallest upper limit of the value axis: smaller values are not magnified.
const plots = [
  { title: 'Force', unit: 'N', decimals: 2, least: 1, series: [['force_n', '--force', 'force']] },
  { title: 'Contacts', unit: '', decimals: 0, least: 5, series: [['contacts', '--colliding', 'contacts']] },
  { title: 'Tick, 1 s', unit: 'µs', decimals: 0, least: 50, series: [['tick_mean_us', '--compute', 'mean'], ['tick_p99_us', '--muted', '99 %']] },
  { title: 'Energy', unit: 'mJ', decimals: 2, least: 1, series: [['energy_mj', '--magnitude', 'net output'], ['stored_mj', '--waiting', 'stored']] },
  { title: 'Stiffness margin', unit: '', times: true, decimals: 1, least: 2, series: [['margin', '--axis-z', 'margin', marginOf]] },
];

// Stiffness margin: factor by which the surface could be stiffer. Known in contact only.
function marginOf({ margin, contacts }) {
  return contacts > 0 && margin > 0 ? margin : null;
}

const numberOf = (value) => (isNumber(value) ? value : null);

// Axis labels: zero, and a round value on the larger side.
const labelled = (low, high) => (high >= -low ? [0, niceFloor(high)] : [-niceFloor(-low), 0]);

function options(plot, width) {
  const grid = { stroke: themeValue('--grid'), width: 1 };
  const axis = { stroke: themeValue('--muted'), grid, ticks: { show: false }, font: '11px system-ui' };
  return {
    width, height, legend: { show: false }, cursor: { show: false }, padding: [6, 4, 4, 0],
    scales: { x: { time: false }, y: { range: (u, low, high) => [Math.min(1.05 * (low ?? 0), 0), 1.05 * Math.max(high ?? 0, plot.least)] } },
    axes: [{ ...axis, show: false }, { ...axis, size: 40, splits: (u, i, low, high) => labelled(low, high) }],
    series: [{}, ...plot.series.map(([, color]) => ({ stroke: themeValue(color), width: 1.5, points: { show: false } }))],
  };
}

class LivePlot {
  constructor(plot, host) {
    this.plot = plot;
    this.values = plot.series.map(() => element('span', { className: 'value' }));
    const labels = plot.series.map(([, color, label], k) =>
      element('span', { className: `curve ${color.slice(2)}` }, plot.series.length > 1 ? `${label} ` : '', this.values[k]));
    this.canvas = element('div', { className: 'plot', attributes: { role: 'img', 'aria-label': `${plot.title} over the last ${span} seconds` } });
    host.append(element('div', { className: 'plot-head' },
      element('h3', { text: plot.title }), element('span', { className: 'unit', text: plot.unit }), ...labels), this.canvas);
  }

  #text(value) {
    const text = formatFixed(value, Math.abs(value) >= manyDigits ? 0 : this.plot.decimals);
    return this.plot.times && isNumber(value) ? `${text}×` : text;
  }

  make(width) {
    this.chart?.destroy();
    this.chart = new uPlot(options(this.plot, width), [[], ...this.plot.series.map(() => [])], this.canvas);
  }

  draw(times, rows, now) {
    const columns = this.plot.series.map(([name, , , of]) => rows.map((row) => numberOf(row && (of ? of(row) : row[name]))));
    const data = [times, ...columns];
    this.chart.setData(data, false);
    this.chart.batch(() => {
      this.chart.setScale('x', { min: now - span, max: now });
    });
    columns.forEach((column, k) => { this.values[k].textContent = this.#text(column.at(-1)); });
  }
}

export class Plots {
  #times = [];
  #rows = [];
  #drawnAt = 0;

  constructor(connection, live) {
    this.live = live;
    this.host = byId('plots');
    this.list = plots.map((plot) => new LivePlot(plot, this.host));
    live.on('diagnostics', () => this.#add(live.diagnostics.values));
    connection.onChange(() => this.#add(null)); // a gap
    const make = () => this.host.clientWidth > 0 && this.list.forEach((plot) => plot.make(this.host.clientWidth));
    new ResizeObserver(make).observe(this.host);
    followTheme(make);
  }

  #add(values) {
    const now = performance.now() / 1000;
    this.#times.push(now);
    this.#rows.push(values);
    const old = this.#times.findIndex((t) => t >= now - span);
    if (old > 0) {
      this.#times.splice(0, old);
      this.#rows.splice(0, old);
    }
  }

  /// Upper limit of every plot, by its title.
  get tops() {
    return Object.fromEntries(this.list.map(({ plot, chart }) => [plot.title, chart.scales.y.max]));
  }

  /// Call before every frame.
  update() {
    const now = performance.now();
    if (now - this.#drawnAt < redrawEvery || this.host.clientWidth === 0 || !this.list[0].chart) return;
    this.#drawnAt = now;
    for (const plot of this.list) plot.draw(this.#times, this.#rows, now / 1000);
  }
}
