// The report page in a real browser. REPORT_PAGE names the built template:
//   REPORT_PAGE=build/web/report/report.html node --test tests/web/report_test.mjs

import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';

import { canvasPixels, launch, openReport, readTemplate, settle } from './page.mjs';
import { liveRun, sphereRun, tinyRun } from './synthetic_run.mjs';

const smallRun = (options) => sphereRun({ rows: 6000, scenePoints: 4000, ...options });
const minus = '\u2212';
const fixed = (value, decimals) => value.toFixed(decimals).replace('-', minus);
const close = (actual, expected, tolerance, what) =>
  assert.ok(Math.abs(actual - expected) <= tolerance, `${what}: ${actual}, expected ${expected} within ${tolerance}`);

const rangesOf = (page) => page.evaluate(() =>
  Object.fromEntries(Object.entries(palpateReport.plots).map(([id, u]) => [id, [u.scales.x.min, u.scales.x.max]])));

const plottingArea = (page, chart) => page.locator(`[data-chart="${chart}"] .u-over`).boundingBox();

/// Page coordinates of a time, and optionally a value, in a chart.
async function pointAt(page, chart, time, value) {
  const area = await plottingArea(page, chart);
  const [x, y] = await page.evaluate(([id, t, v]) => {
    const u = palpateReport.plots[id];
    return [u.valToPos(t, 'x'), v === undefined ? u.over.clientHeight / 2 : u.valToPos(v, 'y')];
  }, [chart, time, value]);
  return { x: area.x + x, y: area.y + y };
}

async function drag(page, from, to) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(0.5 * (from.x + to.x), from.y, { steps: 3 });
  await page.mouse.move(to.x, from.y, { steps: 3 });
  await page.mouse.up();
  await settle(page);
}

const legendValue = (page, series) => page.locator(`[data-series="${series}"] .value`).textContent();

const colorOf = (page, name) => page.evaluate((property) => {
  const probe = document.createElement('canvas').getContext('2d');
  probe.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(property);
  probe.fillRect(0, 0, 1, 1);
  return [...probe.getImageData(0, 0, 1, 1).data];
}, name);

const distance = (a, b) => Math.max(...[0, 1, 2].map((k) => Math.abs(a[k] - b[k])));
const pixelAt = ({ width, data }, x, y) => data.subarray(4 * (y * width + x), 4 * (y * width + x) + 3);

/// Whether a pixel of the colour, or of any but the background, lies within `radius` of (x, y).
function hasPixelNear(pixels, x, y, radius, matches) {
  for (let dy = -radius; dy <= radius; ++dy) {
    for (let dx = -radius; dx <= radius; ++dx) {
      const [px, py] = [Math.round(x) + dx, Math.round(y) + dy];
      const inside = px >= 0 && py >= 0 && px < pixels.width && py < pixels.height;
      if (inside && matches(pixelAt(pixels, px, py))) return true;
    }
  }
  return false;
}

function countDifferences(a, b) {
  let count = 0;
  for (let i = 0; i < a.data.length; i += 4) {
    if (Math.max(...[0, 1, 2].map((k) => Math.abs(a.data[i + k] - b.data[i + k]))) > 8) ++count;
  }
  return count;
}

describe('template', () => {
  test('each placeholder occurs once, in its element', async () => {
    const template = await readTemplate();
    assert.equal(template.split('<!--PALPATE_RUN_JSON-->').length, 2);
    assert.equal(template.split('<!--PALPATE_TITLE-->').length, 2);
    assert.ok(template.includes('<script type="application/json" id="run"><!--PALPATE_RUN_JSON--></script>'));
    assert.ok(template.includes('<title><!--PALPATE_TITLE--></title>'));
  });

  test('scripts end only where their elements end', async () => {
    const template = await readTemplate();
    assert.equal(template.match(/<\/script/gi).length, template.match(/<script\b/gi).length);
  });
});

describe('report', () => {
  let browser;
  let report;
  let page;
  const run = smallRun();

  before(async () => {
    browser = await launch();
    report = await openReport(browser, run);
    ({ page } = report);
  });
  after(async () => {
    await report?.close();
    await browser?.close();
  });

  test('loads nothing and reports no errors', () => assert.deepEqual(report.problems, []));

  test('header shows the title and the summary', async () => {
    assert.equal(await page.locator('h1').textContent(), run.title);
    assert.equal(await page.title(), run.title);
    assert.deepEqual(await page.locator('#summary dt').allTextContents(), run.summary.map((s) => s.label));
    assert.deepEqual(await page.locator('#summary dd').allTextContents(), run.summary.map((s) => s.value));
  });

  test('charts appear in order, torque only where there is torque', async () => {
    const ids = await page.locator('[data-chart]').evaluateAll((nodes) => nodes.map((n) => n.dataset.chart));
    assert.deepEqual(ids, ['counts', 'force', 'user', 'compute']);
  });

  test('each chart draws its series in their colours', async () => {
    for (const [chart, names] of [['counts', ['candidates', 'filtered', 'colliding']],
      ['force', ['axis-x', 'axis-y', 'axis-z', 'magnitude']], ['compute', ['compute']]]) {
      const pixels = await canvasPixels(page, `[data-chart="${chart}"]`);
      for (const name of names) {
        const color = await colorOf(page, `--${name}`);
        const drawn = hasPixelNear(pixels, pixels.width / 2, pixels.height / 2,
          Math.ceil(pixels.width / 2), (p) => distance(p, color) < 24);
        assert.ok(drawn, `${chart} draws --${name}`);
      }
    }
  });

  test('the charts share one time axis to the pixel', async () => {
    const areas = await Promise.all(['counts', 'force', 'user', 'compute'].map((c) => plottingArea(page, c)));
    for (const area of areas) assert.deepEqual([area.x, area.width], [areas[0].x, areas[0].width]);
  });

  test('zeros lie on a floor of the log axis that reads 0', async () => {
    const { floor, ticks, bottom } = await page.evaluate(() => {
      const u = palpateReport.plots.counts;
      const splits = u.axes[1].splits(u, 1, u.scales.y.min, u.scales.y.max);
      return { floor: u.data[3][0], ticks: u.axes[1].values(u, splits), bottom: u.scales.y.min };
    });
    assert.equal(run.columns.colliding[0], 0);
    assert.ok(floor > 0 && floor < 1 && bottom < floor, `floor ${floor} above ${bottom}`);
    assert.deepEqual(ticks.slice(0, 3), ['0', '1', '10']);
    const pixels = await canvasPixels(page, '[data-chart="counts"]');
    const color = await colorOf(page, '--colliding');
    const [x, y] = await page.evaluate(([t, v]) => {
      const u = palpateReport.plots.counts;
      return [u.valToPos(t, 'x', true), u.valToPos(v, 'y', true)];
    }, [0.1, floor]);
    assert.ok(hasPixelNear(pixels, x, y, 2, (p) => distance(p, color) < 24), 'a line of zeros is drawn');
  });

  test('hover shows the values of the nearest row on all charts', async () => {
    for (const row of [700, 3100, 12]) {
      const at = await pointAt(page, 'force', run.columns.t[row]);
      await page.mouse.move(at.x, at.y);
      const hovered = await page.evaluate(() => palpateReport.timeline.row);
      const perPixel = run.columns.t.length / (await plottingArea(page, 'force')).width;
      close(hovered, row, Math.ceil(perPixel), 'row under the pointer');
      const value = (name) => run.columns[name][hovered];
      for (const name of ['candidates', 'filtered', 'colliding']) {
        assert.equal(await legendValue(page, name), String(value(name)));
      }
      for (const name of ['fx', 'fy', 'fz', 'ufx', 'ufy', 'ufz']) {
        assert.equal(await legendValue(page, name), fixed(value(name), 3));
      }
      assert.equal(await legendValue(page, 'force'), fixed(Math.hypot(value('fx'), value('fy'), value('fz')), 3));
      assert.equal(await legendValue(page, 'time'), fixed(value('compute_us'), 1));
      assert.match(await page.locator('#instant').textContent(), new RegExp(`t = ${value('t').toFixed(3)} s`));
    }
  });

  test('onset labels stand over their onsets', async () => {
    const labels = page.locator('.onset');
    assert.deepEqual(await labels.allTextContents(), ['ta', 'tb', 'tc', 'td', 'te', 'tf', 'tg']);
    for (const [i, episode] of run.episodes.entries()) {
      const box = await labels.nth(i).boundingBox();
      const at = await pointAt(page, 'counts', episode.onset_t);
      close(box.x + 0.5 * box.width, at.x, 2, `label ${i}`);
    }
  });

  test('onset lines cross every chart', async () => {
    const expected = await colorOf(page, '--accent');
    for (const chart of ['counts', 'force', 'user', 'compute']) {
      const pixels = await canvasPixels(page, `[data-chart="${chart}"]`);
      const [x, top] = await page.evaluate(([id, t]) => {
        const u = palpateReport.plots[id];
        return [u.valToPos(t, 'x', true), u.bbox.top + 6];
      }, [chart, run.episodes[2].onset_t]);
      const reddish = (p) => p[0] - p[1] > 0.3 * (expected[0] - expected[1]) && p[2] > p[1];
      assert.ok(hasPixelNear(pixels, x, top, 1, reddish), `${chart} has the line of t_c`);
    }
  });

  test('dragging on one chart zooms all, resets bring back the whole run', async () => {
    const whole = await rangesOf(page);
    const full = [run.columns.t[0], run.columns.t.at(-1)];
    for (const range of Object.values(whole)) assert.deepEqual(range, full);
    const resets = [
      () => page.locator('#reset-zoom').click(),
      async () => {
        const at = await pointAt(page, 'user', 2.5);
        await page.mouse.dblclick(at.x, at.y);
      },
      () => page.locator('#charts').press('Escape'),
    ];
    for (const reset of resets) {
      await drag(page, await pointAt(page, 'compute', 3.5), await pointAt(page, 'compute', 2));
      for (const [id, [min, max]] of Object.entries(await rangesOf(page))) {
        close(min, 2, 0.02, `${id} from`);
        close(max, 3.5, 0.02, `${id} to`);
      }
      await reset();
      await settle(page);
      assert.deepEqual(await rangesOf(page), whole);
    }
    assert.ok(await page.locator('#reset-zoom').isDisabled());
  });

  test('labels follow the zoom', async () => {
    await page.evaluate(() => palpateReport.timeline.setRange(1, 3));
    await settle(page);
    for (const [i, { onset_t: onset }] of run.episodes.entries()) {
      const label = page.locator('.onset').nth(i);
      assert.equal(await label.isVisible(), onset >= 1 && onset <= 3, `label ${i} at ${onset}`);
      if (onset < 1 || onset > 3) continue;
      const box = await label.boundingBox();
      close(box.x + 0.5 * box.width, (await pointAt(page, 'counts', onset)).x, 2, `label ${i}`);
    }
    await page.evaluate(() => palpateReport.timeline.reset());
  });

  test('Shift-drag moves the zoomed stretch', async () => {
    await page.evaluate(() => palpateReport.timeline.setRange(2, 4));
    await settle(page);
    await page.keyboard.down('Shift');
    await drag(page, await pointAt(page, 'force', 3), await pointAt(page, 'force', 3.5));
    await page.keyboard.up('Shift');
    const [min, max] = (await rangesOf(page)).counts;
    close(min, 1.5, 0.03, 'from');
    close(max, 3.5, 0.03, 'to');
    await page.evaluate(() => palpateReport.timeline.reset());
  });

  test('arrow keys step through the rows', async () => {
    await page.evaluate(() => palpateReport.timeline.setRow(100));
    await page.locator('#charts').press('ArrowRight');
    assert.equal(await page.evaluate(() => palpateReport.timeline.row), 101);
    await page.locator('#charts').press('ArrowLeft');
    await page.locator('#charts').press('ArrowLeft');
    assert.equal(await page.evaluate(() => palpateReport.timeline.row), 99);
  });

  test('a legend entry hides its line', async () => {
    const color = await colorOf(page, '--colliding');
    const shows = async () => {
      await settle(page);
      const pixels = await canvasPixels(page, '[data-chart="counts"]');
      return hasPixelNear(pixels, pixels.width / 2, pixels.height / 2, pixels.width, (p) => distance(p, color) < 16);
    };
    assert.ok(await shows());
    await page.locator('[data-series="colliding"]').click();
    assert.ok(!(await shows()));
    await page.locator('[data-series="colliding"]').click();
    assert.ok(await shows());
  });

  test('the table has the figures of each contact', async () => {
    const rows = page.locator('#contacts tbody tr');
    assert.equal(await rows.count(), run.episodes.length);
    for (const [i, e] of run.episodes.entries()) {
      const depths = run.contacts.depth.filter((_, k) => run.contacts.row[k] >= e.first && run.contacts.row[k] <= e.last);
      assert.deepEqual(await rows.nth(i).locator('td').allTextContents(), [
        fixed(e.onset_t, 3), fixed(e.duration_s, 3), e.position.map((v) => fixed(v, 3)).join(', '),
        String(e.peak_colliding), fixed(e.peak_force, 3), fixed(1000 * Math.max(...depths), 2),
      ]);
    }
  });

  test('choosing a contact, by mouse or key, zooms to it and moves the tool', async () => {
    const chooseBy = [
      (row) => row.locator('td').nth(3).click(),
      async (row) => { await row.locator('button').focus(); await page.keyboard.press('Enter'); },
    ];
    for (const [i, choose] of chooseBy.entries()) {
      const episode = run.episodes[2 + i];
      await choose(page.locator('#contacts tbody tr').nth(2 + i));
      await settle(page);
      const end = run.columns.t[episode.last];
      const [min, max] = (await rangesOf(page)).force;
      assert.ok(min < episode.onset_t && max > end, 'the contact is in sight with a margin');
      assert.ok(max - min < 3 * episode.duration_s, 'and fills most of the charts');
      const { row, marker } = await page.evaluate(() =>
        ({ row: palpateReport.timeline.row, marker: palpateReport.view.marker.position.toArray() }));
      assert.equal(row, episode.peak);
      ['x', 'y', 'z'].forEach((axis, k) => close(marker[k], run.columns[axis][row], 1e-12, `tool ${axis}`));
      assert.equal(await page.locator('tr[aria-current]').count(), 1);
    }
    await page.locator('#reset-zoom').click();
    assert.equal(await page.locator('tr[aria-current]').count(), 0);
  });

  test('the tool marker has the size and orientation of the tool', async () => {
    const row = 1500;
    const { scale, q } = await page.evaluate((r) => {
      palpateReport.timeline.setRow(r);
      const { marker } = palpateReport.view;
      return { scale: marker.children[0].scale.toArray(), q: marker.quaternion.toArray() };
    }, row);
    assert.deepEqual(scale, run.tool[0].semi_axes);
    ['qx', 'qy', 'qz', 'qw'].forEach((name, k) => close(q[k], run.columns[name][row], 1e-9, name));
  });

  const projected = (position) => page.evaluate((p) => {
    const { view } = palpateReport;
    const scale = view.canvas.width / view.size.width;
    const at = view.project({ x: p[0], y: p[1], z: p[2] });
    return [at.x * scale, at.y * scale];
  }, position);

  test('the view draws the path where the tool was', async () => {
    for (const name of ['scene', 'contacts', 'normals', 'force']) await page.locator(`[data-toggle="${name}"]`).uncheck();
    await page.evaluate(() => palpateReport.timeline.setRow(0));
    await settle(page);
    const pixels = await canvasPixels(page, '#view');
    const color = await colorOf(page, '--path');
    const touching = await colorOf(page, '--colliding');
    for (const row of [400, 900, 2000, 4500]) {
      const at = await projected(['x', 'y', 'z'].map((axis) => run.columns[axis][row]));
      const expected = run.columns.colliding[row] > 0 ? touching : color;
      assert.ok(hasPixelNear(pixels, ...at, 2, (p) => distance(p, expected) < 40), `row ${row} at ${at}`);
    }
    const peak = run.episodes[3].peak;
    const at = await projected(['x', 'y', 'z'].map((axis) => run.columns[axis][peak]));
    assert.ok(hasPixelNear(pixels, ...at, 3, (p) => distance(p, touching) < 40), 'contact is highlighted');
    for (const name of ['scene', 'contacts', 'normals', 'force']) await page.locator(`[data-toggle="${name}"]`).check();
  });

  /// The view once two pictures of it in a row are alike: a slow machine may still be drawing.
  async function stillPixels() {
    let last = await canvasPixels(page, '#view');
    for (let attempt = 0; attempt < 20; attempt += 1) {
      await settle(page);
      const next = await canvasPixels(page, '#view');
      if (countDifferences(last, next) === 0) return next;
      last = next;
    }
    throw new Error('the view does not come to rest');
  }

  test('each toggle changes the picture and back', async () => {
    await settle(page);
    const all = await stillPixels();
    for (const name of ['scene', 'path', 'contacts', 'normals', 'force']) {
      await page.locator(`[data-toggle="${name}"]`).uncheck();
      await settle(page);
      assert.ok(countDifferences(all, await stillPixels()) > 20, `${name} off`);
      await page.locator(`[data-toggle="${name}"]`).check();
      await settle(page);
      assert.equal(countDifferences(all, await stillPixels()), 0, `${name} on again`);
    }
  });

  test('force arrows stand on the path and point where the force does', async () => {
    const ends = await page.evaluate(() => {
      const { instanceStart: from, instanceEnd: to } = palpateReport.view.layers.Force.geometry.attributes;
      const at = (a, i) => [a.getX(i), a.getY(i), a.getZ(i)];
      return [...Array(from.count).keys()].filter((i) => i % 3 === 0).map((i) => [at(from, i), at(to, i)]);
    });
    assert.ok(ends.length > 10);
    const { columns } = run;
    const lengths = ends.map(([from, to]) => {
      const row = columns.x.findIndex((x, i) => Math.hypot(x - from[0], columns.y[i] - from[1], columns.z[i] - from[2]) < 1e-6);
      assert.ok(row >= 0, 'begins at a place of the tool');
      const force = ['fx', 'fy', 'fz'].map((name) => columns[name][row]);
      const arrow = to.map((v, k) => v - from[k]);
      const [f, l] = [Math.hypot(...force), Math.hypot(...arrow)];
      assert.ok(arrow.reduce((sum, v, k) => sum + v * force[k], 0) > 0.9999 * f * l, `row ${row}`);
      return l / f;
    });
    assert.ok(Math.max(...lengths) < 1.001 * Math.min(...lengths), 'all on one scale');
  });

  test('the scene is drawn in its own colours', async () => {
    await page.locator('[data-toggle="path"]').uncheck();
    await settle(page);
    const pixels = await canvasPixels(page, '#view');
    const blue = (p) => p[2] > p[0] + 25;
    const brown = (p) => p[0] > p[2] + 25 && p[1] > p[2];
    const middle = [pixels.width / 2, pixels.height / 2, Math.floor(pixels.height / 3)];
    assert.ok(hasPixelNear(pixels, ...middle, blue) && hasPixelNear(pixels, ...middle, brown));
    await page.locator('[data-toggle="path"]').check();
  });

  test('dragging turns the view, z stays up, reset brings it back', async () => {
    await settle(page);
    const first = await canvasPixels(page, '#view');
    const box = await page.locator('#view canvas').boundingBox();
    const middle = { x: box.x + 0.5 * box.width, y: box.y + 0.5 * box.height };
    await drag(page, middle, { x: middle.x + 90, y: middle.y });
    assert.ok(countDifferences(first, await canvasPixels(page, '#view')) > 200);
    const [low, high] = [await projected([0, 0, -0.3]), await projected([0, 0, 0.3])];
    close(low[0], high[0], 1, 'z axis upright');
    assert.ok(high[1] < low[1]);
    await page.locator('#reset-view').click();
    await settle(page);
    assert.equal(countDifferences(first, await canvasPixels(page, '#view')), 0);
  });

  test('nothing went wrong on the way', () => assert.deepEqual(report.problems, []));
});

describe('a live run', () => {
  let browser;
  let report;
  let page;
  const run = liveRun({ rows: 6000, scenePoints: 4000 });
  const charts = ['counts', 'force', 'sent', 'user', 'speed', 'energy', 'compute'];
  const faults = [['over-speed', 3], ['stale-pose', 8], ['jump', 10]].map(([name, k]) => ({ name, at: run.governor.t[k], row: run.governor.row[k] }));

  before(async () => {
    browser = await launch();
    report = await openReport(browser, run);
    ({ page } = report);
  });
  after(async () => {
    await report?.close();
    await browser?.close();
  });

  test('has charts of its own, in order', async () => {
    const ids = await page.locator('[data-chart]').evaluateAll((nodes) => nodes.map((n) => n.dataset.chart));
    assert.deepEqual(ids, charts);
  });

  test('hover shows what was sent, speed, energy, age and state', async () => {
    for (const row of [100, 1500, 3010, 3300]) {
      await page.evaluate((r) => palpateReport.timeline.setRow(r), row);
      const value = (name) => run.columns[name][row];
      const length = (prefix) => Math.hypot(...['x', 'y', 'z'].map((axis) => value(prefix + axis)));
      for (const name of ['sfx', 'sfy', 'sfz']) assert.equal(await legendValue(page, name), fixed(value(name), 3));
      assert.equal(await legendValue(page, 'sent'), fixed(length('sf'), 3));
      assert.equal(await legendValue(page, 'speed'), fixed(length('v'), 3));
      assert.equal(await legendValue(page, 'energy'), fixed(1000 * value('energy'), 2));
      assert.equal(await legendValue(page, 'stored'), fixed(1000 * value('stored'), 2));
      assert.equal(await legendValue(page, 'age'), fixed(value('age_us'), 1));
      const state = run.governor.states[value('state')];
      assert.match(await page.locator('#instant').textContent(), new RegExp(`${state}$`));
    }
  });

  // The colour of the strip at a time that is in sight.
  async function stripColor(time) {
    const pixels = await canvasPixels(page, '#governor');
    const [min, max] = (await rangesOf(page)).counts;
    const x = Math.round(((time - min) / (max - min)) * (pixels.width - 1));
    return pixelAt(pixels, x, pixels.height >> 1);
  }

  async function assertStripShowsTheStates([from, to]) {
    const { t, state, states } = run.governor;
    let checked = 0;
    for (let k = 0; k < t.length; ++k) {
      const middle = 0.5 * (t[k] + (t[k + 1] ?? run.columns.t.at(-1)));
      if (middle < from || middle > to) continue;
      const expected = await colorOf(page, `--state-${states[state[k]]}`);
      assert.ok(distance(await stripColor(middle), expected) < 8, `${states[state[k]]} at ${middle} s`);
      ++checked;
    }
    return checked;
  }

  test('the strip shows the states in their colours, and lies over the charts', async () => {
    assert.equal(await assertStripShowsTheStates([0, 6]), run.governor.t.length);
    const strip = await page.locator('#governor canvas').boundingBox();
    const area = await plottingArea(page, 'counts');
    close(strip.x, area.x, 1, 'left');
    close(strip.x + strip.width, area.x + area.width, 1, 'right');
    assert.deepEqual(await page.locator('[data-state]').allTextContents(), run.governor.states);
  });

  test('faults are named where they begin', async () => {
    const labels = page.locator('.fault');
    assert.deepEqual(await labels.allTextContents(), faults.map((f) => f.name));
    const box = await labels.nth(0).boundingBox();
    close(box.x + 0.5 * box.width, (await pointAt(page, 'counts', faults[0].at)).x, 2, 'over-speed');
    assert.ok(!(await labels.nth(2).isVisible()), 'no room for jump beside stale-pose');
  });

  test('fault lines cross every chart', async () => {
    const expected = await colorOf(page, '--fault');
    for (const chart of charts) {
      const pixels = await canvasPixels(page, `[data-chart="${chart}"]`);
      const [x, top] = await page.evaluate(([id, t]) => {
        const u = palpateReport.plots[id];
        return [u.valToPos(t, 'x', true), u.bbox.top + 6];
      }, [chart, faults[0].at]);
      const brownish = (p) => p[0] - p[2] > 0.3 * (expected[0] - expected[2]) && p[1] > p[2];
      assert.ok(hasPixelNear(pixels, x, top, 1, brownish), `${chart} has the line of the fault`);
    }
  });

  test('choosing a fault zooms to it, and the strip follows', async () => {
    await page.locator('.fault').nth(1).click();
    await settle(page);
    const [min, max] = (await rangesOf(page)).sent;
    close(min, faults[1].at - 0.5, 1e-9, 'from');
    close(max, faults[1].at + 0.5, 1e-9, 'to');
    assert.equal(await page.evaluate(() => palpateReport.timeline.row), faults[1].row);
    assert.ok(await page.locator('.fault').nth(2).isVisible(), 'room for jump now');
    assert.ok(!(await page.locator('.fault').nth(0).isVisible()), 'over-speed is out of sight');
    assert.ok((await assertStripShowsTheStates([min, max])) >= 4);
    await page.locator('#reset-zoom').click();
  });

  test('nothing went wrong on the way', () => assert.deepEqual(report.problems, []));
});

describe('other runs', () => {
  let browser;
  before(async () => { browser = await launch(); });
  after(() => browser?.close());

  /// Opens a run, checks it, and that nothing went wrong.
  async function withReport(run, context, check) {
    const report = await openReport(browser, run, context);
    try {
      await check(report.page);
      assert.deepEqual(report.problems, []);
    } finally {
      await report.close();
    }
  }

  test('markup in the data stays text', async () => {
    const attack = '</script><script>alert(1)</script><img src=x onerror=alert(2)><!--';
    const run = { ...tinyRun(), title: attack, generator: attack, summary: [{ label: attack, value: attack }] };
    await withReport(run, {}, async (page) => {
      for (const place of ['h1', '#generator', '#summary dt', '#summary dd']) {
        assert.equal(await page.locator(place).textContent(), attack);
      }
      assert.equal(await page.title(), attack);
      assert.equal(await page.locator('img').count(), 0);
    });
  });

  test('one row without contacts or scene', () => withReport(tinyRun(), {}, async (page) => {
    assert.equal(await page.locator('[data-chart]').count(), 3);
    assert.equal(await legendValue(page, 'candidates'), '0');
    assert.equal(await legendValue(page, 'time'), '12.5');
    assert.equal(await page.locator('.onset').count(), 0);
    assert.match(await page.locator('#contacts').textContent(), /touched nothing/);
    assert.equal(await page.locator('[data-toggle]:disabled').count(), 5);
    for (const [min, max] of Object.values(await rangesOf(page))) assert.ok(min < max);
  }));

  test('how it was made is told as it is, and nothing where the run does not say', async () => {
    await withReport({ ...tinyRun(), made: '[made]\nscene = "<b>&"\n' }, {}, async (page) => {
      await page.locator('#made summary').click();
      assert.equal(await page.locator('#made pre').textContent(), '[made]\nscene = "<b>&"\n');
    });
    await withReport(tinyRun(), {}, async (page) => assert.ok(!(await page.locator('#made').isVisible())));
  });

  test('runs over one another: each at its own times, with a colour and figures of its own', async () => {
    const run = smallRun();
    const { t, colliding, fx, fy, fz, compute_us: times } = run.columns;
    // The same half as long with every third row and twice the force, and one that comes later than all.
    const every = (column, change = (v) => v) => column.filter((_, i) => i % 3 === 0 && i < 3000).map(change);
    const twice = { t: every(t), colliding: every(colliding), compute_us: every(times),
      fx: every(fx, (v) => 2 * v), fy: every(fy, (v) => 2 * v), fz: every(fz, (v) => 2 * v) };
    const later = Object.fromEntries(Object.entries(twice).map(([name, column]) => [name, column.slice(0, 9)]));
    later.t = later.t.map((v) => v + 1e6);
    const summary = [{ label: 'Poses', value: '1000' }, { label: 'Odd', value: '<i>' }];
    const others = [{ title: 'twice.csv', made: 'x = 1\n', summary, columns: twice }, { title: 'later.csv', columns: later }, 7];
    await withReport({ ...run, others }, {}, async (page) => {
      const seen = await page.evaluate(() => {
        const u = palpateReport.plots.force;
        const k = u.series.findIndex(({ label }) => label === 'twice.csv');
        const own = u.series.findIndex(({ label }) => label === 'force');
        return { t: u.data[0], own: u.data[own], other: u.data[k], labels: u.series.map(({ label }) => label) };
      });
      assert.equal(seen.labels.at(-1), 'twice.csv'); // of the others nothing is in sight
      assert.ok(!seen.labels.includes('later.csv'));
      for (const i of [0, 300, 1500, 2997]) close(seen.other[i], 2 * seen.own[i], 1e-9, `row ${i}`);
      assert.equal(seen.other[5000], null);
      const head = await page.locator('#runs thead th').allTextContents();
      assert.deepEqual(head.slice(1, 4), [run.title, 'twice.csv', 'later.csv']);
      assert.match(await page.locator('#runs').textContent(), /<i>/);
      assert.equal(await page.locator('[data-chart="counts"] [data-series="twice.csv"]').count(), 1);
      await page.locator('#made summary').click();
      assert.match(await page.locator('#made pre').textContent(), /# twice\.csv\nx = 1/);
    });
    await withReport(run, {}, async (page) => assert.ok(!(await page.locator('#runs-card').isVisible())));
  });

  test('user force only where it was recorded', () =>
    withReport(smallRun({ userForce: false }), {}, async (page) => {
      assert.equal(await page.locator('[data-chart="user"]').count(), 0);
    }));

  test('a run that is not live says nothing of a governor', () =>
    withReport(smallRun(), {}, async (page) => {
      assert.ok(!(await page.locator('#governor').isVisible()));
      assert.equal(await page.locator('.states').count(), 0);
    }));

  test('a live run of which the governor is not told, or wrongly', async () => {
    const odd = { t: ['x', 1], row: [0, 99999999], state: [7, 2], fault: null, states: ['a'], faults: 3 };
    for (const governor of [null, odd, 'text', {}]) {
      await withReport({ ...liveRun({ rows: 600, scenePoints: 10 }), governor }, {}, async (page) => {
        assert.ok(!(await page.locator('#governor').isVisible()));
        assert.equal(await page.locator('[data-chart="sent"]').count(), 1);
      });
    }
  });

  test('torque where there is some', () => {
    const run = smallRun();
    run.columns.ty[40] = 0.25;
    return withReport(run, {}, async (page) => {
      assert.equal(await page.locator('[data-chart="torque"]').count(), 1);
      await page.evaluate(() => palpateReport.timeline.setRow(40));
      assert.equal(await legendValue(page, 'ty'), '0.2500');
    });
  });

  test('missing values are gaps and dashes', () => {
    const run = smallRun();
    for (const name of ['fx', 'compute_us', 'x', 'qw']) run.columns[name][50] = null;
    return withReport(run, {}, async (page) => {
      await page.evaluate(() => palpateReport.timeline.setRow(50));
      for (const name of ['fx', 'force', 'time']) assert.equal(await legendValue(page, name), '\u2013');
      assert.equal(await page.evaluate(() => palpateReport.view.marker.visible), false);
    });
  });

  test('hundreds of contacts: numbers after z, labels never overlap', () =>
    withReport(smallRun({ rows: 20000, touches: 200 }), {}, async (page) => {
      const names = await page.locator('.onset').allTextContents();
      assert.deepEqual(names.slice(24, 28), ['ty', 'tz', 't27', 't28']);
      const boxes = await page.locator('.onset').evaluateAll((nodes) => nodes
        .filter((n) => n.style.visibility === 'visible')
        .map((n) => n.getBoundingClientRect().toJSON()));
      assert.ok(boxes.length > 10);
      for (let i = 1; i < boxes.length; ++i) assert.ok(boxes[i].left >= boxes[i - 1].right);
      assert.equal(await page.locator('#contacts tbody tr').count(), 200);
    }));

  test('tool centres stand in for contact points, and it says so', () =>
    withReport({ ...smallRun(), contacts: null }, {}, async (page) => {
      assert.match(await page.locator('.view-legend').textContent(), /tool centres/);
      assert.ok(await page.locator('[data-toggle="contacts"]').isChecked());
      assert.ok(await page.locator('[data-toggle="normals"]').isDisabled());
    }));

  test('a phone has no horizontal overflow, in light and dark', async () => {
    for (const colorScheme of ['light', 'dark']) {
      const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true, colorScheme };
      await withReport(liveRun({ rows: 6000, scenePoints: 4000 }), phone, async (page) => {
        assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
        const cells = await page.locator('#contacts td').evaluateAll((nodes) =>
          nodes.filter((n) => n.scrollWidth > n.clientWidth + 1).length);
        assert.equal(cells, 0, 'cells that are cut off');
      });
    }
  });

  test('fingers read values and pinch to zoom', async () => {
    const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
    await withReport(smallRun(), phone, async (page) => {
      const at = await pointAt(page, 'counts', 4);
      await page.touchscreen.tap(at.x, at.y);
      close(await page.evaluate(() => palpateReport.timeline.row), 4000, 30, 'row under the finger');
      const session = await page.context().newCDPSession(page);
      const touch = (type, xs) => session.send('Input.dispatchTouchEvent',
        { type, touchPoints: xs.map((x, id) => ({ x, y: at.y, id })) });
      await touch('touchStart', [150, 250]);
      await touch('touchMove', [120, 280]);
      await touch('touchMove', [100, 300]);
      await touch('touchEnd', []);
      const [min, max] = (await rangesOf(page)).counts;
      close(max - min, 3, 0.3, 'half of six seconds');
    });
  });

  test('the theme follows the system while the page is open', () =>
    withReport(smallRun(), { colorScheme: 'light' }, async (page) => {
      const corner = async () => pixelAt(await canvasPixels(page, '#view'), 2, 2);
      assert.ok((await corner())[0] > 200);
      await page.emulateMedia({ colorScheme: 'dark' });
      await settle(page);
      assert.ok((await corner())[0] < 60);
      const pixels = await canvasPixels(page, '[data-chart="force"]');
      const color = await colorOf(page, '--axis-x');
      assert.ok(hasPixelNear(pixels, pixels.width / 2, pixels.height / 2, pixels.width, (p) => distance(p, color) < 16));
    }));

  test('printing lays the page out for paper, light, and back', () =>
    withReport(liveRun({ rows: 6000, scenePoints: 4000 }), { colorScheme: 'dark' }, async (page) => {
      const state = async (event) => {
        await page.evaluate((name) => window.dispatchEvent(new Event(name)), event);
        await settle(page);
        const { onset_t: onset } = smallRun().episodes[6];
        const box = await page.locator('.onset').nth(6).boundingBox();
        close(box.x + 0.5 * box.width, (await pointAt(page, 'counts', onset)).x, 2, `label on ${event}`);
        const [strip, area] = [await page.locator('#governor canvas').boundingBox(), await plottingArea(page, 'counts')];
        close(strip.width, area.width, 1, `strip on ${event}`);
        const [red] = pixelAt(await canvasPixels(page, '#view'), 2, 2);
        return { red, width: await page.evaluate(() => palpateReport.plots.counts.width) };
      };
      const printed = await state('beforeprint');
      assert.ok(printed.red > 200 && printed.width <= 680, JSON.stringify(printed));
      const shown = await state('afterprint');
      assert.ok(shown.red < 60 && shown.width > 700, JSON.stringify(shown));
    }));

  test('300,000 rows stay usable', () =>
    withReport(smallRun({ rows: 300000 }), {}, async (page) => {
      const elapsed = await page.evaluate(async () => {
        const start = performance.now();
        palpateReport.timeline.setRange(50, 200);
        await null;
        await null;
        for (let row = 0; row < 100; ++row) palpateReport.timeline.setRow(60000 + row);
        return performance.now() - start;
      });
      assert.ok(elapsed < 2000, `a zoom and a hundred moves took ${elapsed} ms`);
    }));
});

describe('without WebGL', () => {
  test('a message stands in for the view, the rest works', async () => {
    const browser = await launch({ webgl: false });
    try {
      const { page, problems, close: closeReport } = await openReport(browser, smallRun());
      assert.match(await page.locator('#view').textContent(), /needs WebGL/);
      assert.equal(await page.locator('#view canvas').count(), 0);
      await page.locator('#contacts tbody tr').first().click();
      await settle(page);
      const [min, max] = (await rangesOf(page)).counts;
      assert.ok(max - min < 1);
      assert.deepEqual(problems, []);
      await closeReport();
    } finally {
      await browser.close();
    }
  });
});
