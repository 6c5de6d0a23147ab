// A capture that is a mirror image: what is drawn, what can be felt and what is picked lie where the program says.

import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';

import { ask, colorsOf, picture, settle, until } from './browser.mjs';
import { desk, distance, frameAll, openDesk, openSection, requests, resetDesk } from './desk.mjs';
import { colourfulScene, mirrored, mirrorImage, needleScene } from './mock_scene.mjs';

const part = { x: 20, y: 130, width: 520, height: 350 }; // of the page: the view and nothing else
const besides = [-0.5, 0, 0]; // where the tool waits: the mirrored places are in the picture, too
const shares = [-1.2, 0, 1.2];
const spread = (color) => Math.max(...color) - Math.min(...color);

async function pressMirrored() {
  await openSection('Placement');
  const before = Boolean(desk.gateway.parameters.registration.mirrored);
  await desk.page.getByRole('button', { name: 'Mirrored' }).click();
  await desk.page.waitForFunction((was) => document.querySelector('[data-action=mirrored]').getAttribute('aria-pressed') === String(!was), before);
  assert.equal(desk.gateway.parameters.registration.mirrored, !before);
  await settle(desk.page, 8);
}

/// A point along the longest axis of a Gaussian, in its own frame. Turns are w, x, y, z.
function along({ center, turn: [w, x, y, z], deviations }, by) {
  const axis = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
  return center.map((c, k) => c + by * deviations[0] * axis[k]);
}

/// That needles are drawn along `place` of their axes, and not where `elsewhere` says.
async function checkNeedles(place, ...elsewhere) {
  const points = desk.gateway.gaussians.slice(0, 3).flatMap((needle) => shares.map((by) => ({ needle, by, point: along(needle, by) })));
  const colors = await colorsOf(desk.page, [place, ...elsewhere].flatMap((where) => points.map(({ point }) => where(point))));
  points.forEach(({ needle, by }, i) => {
    const color = colors[i];
    const strongest = needle.rgb.indexOf(Math.max(...needle.rgb));
    assert.equal(color.indexOf(Math.max(...color)), strongest, `${color} is not the colour of needle ${needle.row}`);
    assert.ok(spread(color) > 60, `${color} at ${by} of needle ${needle.row}`);
    assert.ok(spread(colors[points.length + i]) < 20, `needle ${needle.row} is elsewhere, too`);
  });
}

// Where a needle's end would be that is put to its mirrored place and keeps its turn.
function unturned(needle) {
  const end = along(needle, 1.2);
  return mirrored(needle.center).map((c, k) => c + end[k] - needle.center[k]);
}

const show = (on) => desk.page.evaluate((shown) => {
  for (const part of document.querySelectorAll('.hint-card, .bar, .legend')) part.hidden = !shown;
}, on);

async function open(scene, registration = {}) {
  await show(true);
  await resetDesk({ scene, at: besides });
  desk.gateway.change({ registration });
  await until(desk.page, (scale) => window.palpateViewer.parameters().registration.scale === scale, desk.gateway.parameters.registration.scale);
  await frameAll();
  await show(false); // they would cover some needles
}

describe('a mirrored capture', () => {
  const needles = needleScene();
  before(openDesk);
  after(() => show(true));

  test('the button asks for it, and the needles go to the other side and tilt the other way', async () => {
    await open(needles, { translation: [0.1, 0, 0], scale: 2 });
    const placed = (p) => [2 * p[0] + 0.1, 2 * p[1], 2 * p[2]];
    const reflected = (p) => placed(mirrored(p));
    await checkNeedles(placed, reflected);
    await pressMirrored();
    const asked = requests('set_parameters').map((r) => JSON.parse(r.args.json));
    assert.deepEqual(asked, [{ registration: { mirrored: true } }]);
    await checkNeedles(reflected, placed);
    const wrong = await colorsOf(desk.page, needles.gaussians.slice(0, 3).map((needle) => placed(unturned(needle))));
    wrong.forEach((color, row) => assert.ok(spread(color) < 20, `needle ${row} has kept its turn`));
    await pressMirrored();
    await checkNeedles(placed, reflected);
  });

  test('colours are those seen from the other side, and what can be felt is drawn and picked there', async () => {
    await open(needles);
    const middle = async () => (await colorsOf(desk.page, [[0, 0, 0]]))[0];
    const [red, , blue] = await middle();
    assert.ok(red > blue + 15, `${red} and ${blue}: as seen from +x`);
    await pressMirrored();
    const seen = await middle();
    assert.ok(seen[0] < seen[2] - 15, `${seen}: as seen from -x`);
    const points = desk.gateway.gaussians.slice(0, 3).flatMap((needle) => [-1, 0, 1].map((by) => along(needle, by)));
    for (const point of points) {
      const picked = await ask(desk.page, (v, p) => v.pick(v.project(p)), mirrored(point));
      assert.ok(picked && distance(picked, mirrored(point)) < 0.01, `${picked} is not ${mirrored(point)}`);
      assert.equal(await ask(desk.page, (v, p) => v.pick(v.project(p)), point), null);
    }
    await desk.page.locator('[data-toggle=scene]').uncheck();
    await desk.page.locator('[data-toggle=felt]').check();
    await until(desk.page, () => window.palpateViewer.felt() === 4);
    await settle(desk.page);
    const ends = desk.gateway.gaussians.slice(0, 3).map((needle) => along(needle, 0.6));
    const [background, ...colors] = await colorsOf(desk.page, [[-0.4, 0, 0], ...ends.map(mirrored), ...ends]);
    ends.forEach((_, i) => {
      assert.ok(distance(colors[i], background) > 30, `needle ${i} can be felt there`);
      assert.ok(distance(colors[ends.length + i], background) < 10, 'and not where it was');
    });
    await desk.page.locator('[data-toggle=scene]').check();
    await desk.page.locator('[data-toggle=felt]').uncheck();
  });

  test('it looks as if the file itself were mirrored, in all degrees of colour', async () => {
    const scene = colourfulScene(60, 1);
    const seen = async () => (await picture(desk.page, part)).data;
    await open(mirrorImage(scene));
    const wanted = await seen();
    await open(scene);
    const before = await seen();
    await pressMirrored();
    await show(true);
    await frameAll();
    await show(false);
    const drawn = await seen();
    const apart = (a, b) => a.reduce((sum, c, i) => sum + Math.abs(c - b[i]), 0) / a.length;
    assert.ok(apart(wanted, before) > 5, 'the scene is symmetrical');
    assert.ok(apart(wanted, drawn) < 0.3, `${apart(wanted, drawn)} of 255 apart`);
  });
});
