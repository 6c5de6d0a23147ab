// A capture that is a mirror image: what is drawn, what can be felt and what is picked lie where the program says.

import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';

import { ask, launch, openViewer, picture, pixel, settle, until } from './browser.mjs';
import { MockGateway } from './mock_gateway.mjs';
import { colourfulScene, mirrored, mirrorImage, needleScene } from './mock_scene.mjs';

const part = { x: 20, y: 130, width: 520, height: 350 }; // of the page: the view and nothing else

let browser;
let gateway;
let page;
let problems;

const norm = (v) => Math.hypot(...v);
const distance = (a, b) => norm(a.map((c, k) => c - b[k]));
const spread = (color) => Math.max(...color) - Math.min(...color);

const besides = [-0.5, 0, 0]; // where the tool waits: the mirrored places are in the picture, too

/// Opens the viewer on a scene, framed as a whole.
async function open(scene, registration = {}) {
  gateway = await new MockGateway(process.env.VIEWER_FOLDER, scene).start();
  gateway.tool.position = besides;
  gateway.change({ registration });
  ({ page, problems } = await openViewer(browser, gateway.url));
  await frame();
}

async function frame() {
  await page.getByRole('button', { name: 'Frame all' }).click();
  await settle(page, 8); // drawn as soon as it is sorted
}

async function close() {
  await page.close();
  await gateway.stop();
  assert.deepEqual(problems, []);
}

async function pressMirrored() {
  await page.evaluate(() => { document.getElementById('placement').closest('details').open = true; });
  const before = Boolean(gateway.parameters.registration.mirrored);
  const button = page.getByRole('button', { name: 'Mirrored' });
  await button.click();
  await page.waitForFunction((was) => document.querySelector('[data-action=mirrored]').getAttribute('aria-pressed') === String(!was), before);
  assert.equal(gateway.parameters.registration.mirrored, !before);
  await settle(page, 8);
}

/// A point along the longest axis of a Gaussian, in its own frame. Turns are w, x, y, z.
function along({ center, turn: [w, x, y, z], deviations }, by) {
  const axis = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
  return center.map((c, k) => c + by * deviations[0] * axis[k]);
}

const colorAt = async (point) => pixel(page, await ask(page, (v, p) => v.project(p), point));

/// That needles are drawn along `place` of their axes, and not where `elsewhere` says.
async function checkNeedles(place, elsewhere) {
  for (const needle of gateway.gaussians.slice(0, 3)) {
    const strongest = needle.rgb.indexOf(Math.max(...needle.rgb));
    for (const by of [-1.2, 0, 1.2]) {
      const color = await colorAt(place(along(needle, by)));
      assert.equal(color.indexOf(Math.max(...color)), strongest, `${color} is not the colour of needle ${needle.row}`);
      assert.ok(spread(color) > 60, `${color} at ${by} of needle ${needle.row}`);
      assert.ok(spread(await colorAt(elsewhere(along(needle, by)))) < 20, `needle ${needle.row} is elsewhere, too`);
    }
  }
}

const same = (p) => p;
// Where a needle would be that is put to its mirrored place and keeps its turn.
const unturned = (scene) => (p) => {
  const { center } = scene.gaussians.find((g) => distance(g.center, p) < 0.07);
  return mirrored(center).map((c, k) => c + p[k] - center[k]);
};

before(async () => { browser = await launch(); });
after(() => browser.close());
afterEach(close);

test('the button asks for it, and the needles go to the other side and tilt the other way', async () => {
  const scene = needleScene();
  await open(scene, { translation: [0.1, 0, 0], scale: 2 });
  const placed = (p) => [2 * p[0] + 0.1, 2 * p[1], 2 * p[2]];
  await checkNeedles(placed, (p) => placed(mirrored(p)));
  await pressMirrored();
  const asked = gateway.requests.filter((r) => r.service === '/palpate/set_parameters').map((r) => JSON.parse(r.args.json));
  assert.deepEqual(asked, [{ registration: { mirrored: true } }]);
  await checkNeedles((p) => placed(mirrored(p)), placed);
  for (const needle of scene.gaussians.slice(0, 3)) {
    const wrong = placed(unturned(scene)(along(needle, 1.2)));
    assert.ok(spread(await colorAt(wrong)) < 20, `needle ${needle.row} has kept its turn`);
  }
  await pressMirrored();
  await checkNeedles(placed, (p) => placed(mirrored(p)));
});

test('colours are those seen from the other side', async () => {
  await open(needleScene());
  const [red, , blue] = await colorAt([0, 0, 0]);
  assert.ok(red > blue + 15, `${red} and ${blue}: as seen from +x`);
  await pressMirrored();
  const seen = await colorAt([0, 0, 0]);
  assert.ok(seen[0] < seen[2] - 15, `${seen}: as seen from -x`);
});

test('what can be felt is drawn there, and picked there', async () => {
  await open(needleScene());
  await pressMirrored();
  for (const needle of gateway.gaussians.slice(0, 3)) {
    for (const by of [-1, 0, 1]) {
      const point = mirrored(along(needle, by));
      const picked = await ask(page, (v, p) => v.pick(v.project(p)), point);
      assert.ok(picked && distance(picked, point) < 0.01, `${picked} is not ${point}`);
      assert.equal(await ask(page, (v, p) => v.pick(v.project(p)), along(needle, by)), null);
    }
  }
  await page.locator('[data-toggle=scene]').uncheck();
  const background = await colorAt([-0.4, 0, 0]);
  await page.locator('[data-toggle=felt]').check();
  await until(page, () => window.palpateViewer.felt() === 4);
  await settle(page);
  for (const needle of gateway.gaussians.slice(0, 3)) {
    assert.ok(distance(await colorAt(mirrored(along(needle, 0.6))), background) > 30, `needle ${needle.row} can be felt there`);
    assert.ok(distance(await colorAt(along(needle, 0.6)), background) < 10, `and not where it was`);
  }
});

test('it looks as if the file itself were mirrored, in all degrees of colour', async () => {
  const scene = colourfulScene(60, 1);
  const seen = async (mirror) => {
    if (mirror) await pressMirrored();
    await frame();
    return picture(page, part);
  };
  await open(mirrorImage(scene));
  const wanted = await seen(false);
  await close();
  await open(scene);
  const before = await seen(false);
  const drawn = await seen(true);
  const apart = (a, b) => a.reduce((sum, c, i) => sum + Math.abs(c - b[i]), 0) / a.length;
  assert.ok(apart(wanted, before) > 5, 'the scene is symmetrical');
  assert.ok(apart(wanted, drawn) < 0.3, `${apart(wanted, drawn)} of 255 apart`);
});
