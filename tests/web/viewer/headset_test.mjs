// The viewer in a headset that is emulated, against the stand-in for the program.

import assert from 'node:assert/strict';
import { after, afterEach, before, beforeEach, test } from 'node:test';

import { ask, headsetScript, launch, openViewer, settle, until } from './browser.mjs';
import { MockGateway } from './mock_gateway.mjs';
import { ballScene, radius } from './mock_scene.mjs';

const clear = [0, 0, 0.3];
// WebXR's x, y, z of a point of the world, while `room` is as it is put first for a small scene: its middle is half
// a metre ahead of the origin and 1.1 m up.
const inRoom = ([x, y, z]) => [x, 1.1 + z, -(0.5 + y)];

let browser;
let gateway;
let page;
let problems;

const distance = (a, b) => Math.hypot(...a.map((c, k) => c - b[k]));

const put = (hand, position) => page.evaluate(([side, p]) => {
  window.headset.controllers[side].position.set(...p);
}, [hand, position]);
const press = (hand, button, value) => page.evaluate(([side, id, v]) => {
  window.headset.controllers[side].updateButtonValue(id, v);
}, [hand, button, value]);
const room = () => gateway.parameters.room;

async function waitFor(condition, what) {
  for (const end = Date.now() + 30000; Date.now() < end;) {
    if (condition()) return;
    await new Promise((done) => { setTimeout(done, 20); });
  }
  assert.fail(`did not come: ${what}`);
}

// Where the controller's grip is for the page, which is a few centimetres from its position.
async function moveGripTo(target) {
  await put('right', inRoom(target));
  await settle(page, 3);
  const at = gateway.tool.position;
  await put('right', inRoom(target.map((c, k) => 2 * c - at[k])));
  await waitFor(() => distance(gateway.tool.position, target) < 2e-3, `the tool at ${target}, not ${gateway.tool.position}`);
}

before(async () => { browser = await launch(); });
after(() => browser.close());
beforeEach(async () => {
  gateway = await new MockGateway(process.env.VIEWER_FOLDER, ballScene(200)).start();
  gateway.tool.position = clear;
  ({ page, problems } = await openViewer(browser, gateway.url, {
    script: await headsetScript(), context: { viewport: { width: 480, height: 360 } },
  }));
  await page.getByRole('button', { name: 'VR', exact: true }).click();
  await until(page, () => window.palpateViewer.presenting);
  await settle(page);
});
afterEach(async () => {
  await page.close();
  await gateway.stop();
  assert.deepEqual(problems, []);
});

test('the trigger holds the tool at the controller, and letting it go ends that', async () => {
  assert.equal(gateway.poses.length, 0);
  await press('right', 'trigger', 1);
  await waitFor(() => gateway.poses.length > 0, 'poses');
  await moveGripTo([0.05, 0.02, 0.2]);
  await press('right', 'trigger', 0);
  await until(page, () => !window.palpateViewer.held);
});

test('contact is felt as a click, and the strength grows with the force', async () => {
  await press('right', 'trigger', 1);
  await waitFor(() => gateway.poses.length > 0, 'poses');
  await moveGripTo([0, 0, 0.2]);
  assert.deepEqual(await ask(page, (v) => v.pulses), []);
  const meanAt = async (depth) => {
    const from = (await ask(page, (v) => v.pulses)).length;
    await moveGripTo([0, 0, radius + 0.02 - depth]);
    const newtons = gateway.parameters.stiffness * depth;
    await page.waitForFunction(([n, start]) => window.palpateViewer.pulses.slice(start)
      .filter((p) => p.kind === 'hum' && Math.abs(p.force - n) < 1.2).length > 2, [newtons, from]);
    const hums = (await ask(page, (v) => v.pulses)).slice(from).filter((p) => p.kind === 'hum' && Math.abs(p.force - newtons) < 1.2);
    return hums.reduce((sum, p) => sum + p.intensity, 0) / hums.length;
  };
  const strengths = [await meanAt(0.004), await meanAt(0.01), await meanAt(0.018)];
  assert.equal((await ask(page, (v) => v.pulses))[0].kind, 'click');
  assert.ok(strengths[0] < strengths[1] && strengths[1] < strengths[2], `${strengths}`);
  // The controller itself was asked for the last of them.
  const last = await page.evaluate(() => {
    const gamepad = window.headset.controllers.right.inputSource.gamepad;
    const motor = gamepad.hapticActuators[0];
    const state = Object.getOwnPropertySymbols(motor).map((s) => motor[s]).find((v) => v?.lastPulse);
    return state.lastPulse.value;
  });
  assert.ok(Math.abs(last - strengths[2]) < 0.2, `${last}`);
  await moveGripTo([0, 0, 0.2]);
  const count = (await ask(page, (v) => v.pulses)).length;
  await settle(page, 4);
  assert.equal((await ask(page, (v) => v.pulses)).length, count);
});

test('a squeeze moves the world, and the program keeps where it is', async () => {
  await put('right', [0.2, 1.2, -0.3]);
  await settle(page);
  const first = structuredClone(room());
  await press('right', 'squeeze', 1);
  await settle(page);
  await put('right', [0.3, 1.2, -0.3]);
  await settle(page);
  await press('right', 'squeeze', 0);
  await waitFor(() => distance(room().translation, first.translation) > 0, 'a room');
  // The world went 0.1 m to the right with the hand: what was at the room's origin is now to its left.
  assert.ok(Math.abs(room().translation[0] - -0.1) < 1e-3, `${room().translation}`);
  assert.equal(room().scale, 1);
});

test('two squeezes scale the world', async () => {
  await put('left', [-0.1, 1.2, -0.4]);
  await put('right', [0.1, 1.2, -0.4]);
  await settle(page);
  await press('left', 'squeeze', 1);
  await press('right', 'squeeze', 1);
  await settle(page);
  await put('left', [-0.2, 1.2, -0.4]);
  await put('right', [0.2, 1.2, -0.4]);
  await settle(page);
  await press('left', 'squeeze', 0);
  await waitFor(() => room().scale !== 1, 'a scale');
  assert.ok(Math.abs(room().scale - 0.5) < 0.06, `${room().scale}`); // of the world in a metre of the room
});

test('the stick turns, A stops and resumes, B leaves', async () => {
  await page.evaluate(() => window.headset.controllers.right.updateAxes('thumbstick', 1, 0));
  await waitFor(() => Math.abs(room().rotation[0]) < 1, 'a turn');
  assert.ok(Math.abs(2 * Math.acos(room().rotation[0]) - Math.PI / 6) < 1e-6);
  const requested = (name) => gateway.requests.filter((r) => r.service === `/palpate/${name}`).length;
  const click = async (id) => {
    await press('right', id, 1);
    await settle(page);
    await press('right', id, 0);
    await settle(page);
  };
  await click('a-button');
  await waitFor(() => requested('emergency_stop') === 1, 'a stop');
  await page.waitForFunction(() => document.getElementById('pause').textContent === 'Resume');
  await click('a-button');
  await waitFor(() => requested('resume') === 1, 'resume');
  await press('right', 'b-button', 1);
  await until(page, () => !window.palpateViewer.presenting);
  const at = await ask(page, (v) => v.project([0, 0, 0])); // the world is where it was before
  assert.ok(at !== null);
});
