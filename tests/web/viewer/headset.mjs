// The page in a headset that is emulated. It is entered once.

import assert from 'node:assert/strict';
import { after, before, beforeEach, describe, test } from 'node:test';

import { ask, settle, until, waitFor } from './browser.mjs';
import { clear, desk, distance, openDesk, requests, resetDesk } from './desk.mjs';
import { ballScene, radius } from './mock_scene.mjs';

// WebXR's x, y, z of a point of the world, while `room` is as it is put first for a small scene: its middle is half
// a metre ahead of the origin and 1.1 m up.
const inRoom = ([x, y, z]) => [x, 1.1 + z, -(0.5 + y)];
const resting = { left: [-0.3, 1.2, -0.2], right: [0.3, 1.2, -0.2] };
const upright = { x: 0, y: 0, z: 0, w: 1 };

const put = (hand, position, orientation = upright) => desk.page.evaluate(([side, p, q]) => {
  window.headset.controllers[side].position.set(...p);
  window.headset.controllers[side].quaternion.set(q.x, q.y, q.z, q.w);
}, [hand, position, orientation]);
const press = (hand, button, value) => desk.page.evaluate(([side, id, v]) => {
  window.headset.controllers[side].updateButtonValue(id, v);
}, [hand, button, value]);
const stick = (x, y) => desk.page.evaluate(([a, b]) => window.headset.controllers.right.updateAxes('thumbstick', a, b), [x, y]);
const look = (y) => desk.page.evaluate((angle) => window.headset.quaternion.set(0, Math.sin(angle / 2), 0, Math.cos(angle / 2)), y);
const room = () => desk.gateway.parameters.room;
const seen = () => ask(desk.page, (v) => v.vr());

async function click(hand, id) {
  await press(hand, id, 1);
  await settle(desk.page, 2);
  await press(hand, id, 0);
  await settle(desk.page, 2);
}

// Where the controller's grip is for the page, which is a few centimetres from its position.
async function moveGripTo(target) {
  await put('right', inRoom(target));
  await settle(desk.page, 3);
  const at = desk.gateway.tool.position;
  await put('right', inRoom(target.map((c, k) => 2 * c - at[k])));
  await waitFor(() => distance(desk.gateway.tool.position, target) < 2e-3, `the tool at ${target}, not ${desk.gateway.tool.position}`);
}

// Points the right hand at a button of the panel: from 0.3 m before it.
async function pointAt(name) {
  const target = await ask(desk.page, (v, n) => v.panelButton(n), name);
  const from = [target[0], target[1], target[2] + 0.3];
  await put('right', from);
  for (let k = 0; k < 20; k += 1) { // the ray does not begin where the controller is
    await settle(desk.page, 2);
    if ((await seen()).hovered === name) return;
    const { origin, direction } = await ask(desk.page, (v) => v.pointing());
    const share = (target[2] - origin[2]) / direction[2];
    const miss = target.map((c, i) => c - (origin[i] + share * direction[i]));
    from.forEach((c, i) => { from[i] = c + miss[i]; });
    await put('right', from);
  }
  assert.fail(`${name} is not pointed at: ${(await seen()).hovered}`);
}

describe('in a headset', () => {
  before(async () => {
    await openDesk();
    await resetDesk({ at: [0, 0, 0.3] });
    await desk.page.setViewportSize({ width: 480, height: 360 });
    await desk.page.evaluate(() => window.headset.position.set(0, 1.5, 0.1));
    await desk.page.getByRole('button', { name: 'VR', exact: true }).click();
    await until(desk.page, () => window.palpateViewer.presenting);
    await settle(desk.page);
    for (const side of ['left', 'right']) await put(side, resting[side]);
  });
  beforeEach(async () => {
    await resetDesk({ at: [0, 0, 0.3], parameters: { room: first } });
    for (const side of ['left', 'right']) {
      for (const id of ['trigger', 'squeeze']) await press(side, id, 0);
      await put(side, resting[side]);
    }
    await look(0);
    await settle(desk.page);
  });
  after(async () => {
    await press('right', 'b-button', 1);
    await until(desk.page, () => !window.palpateViewer.presenting);
    const at = await ask(desk.page, (v) => v.project([0, 0, 0])); // the world is where it was before
    assert.ok(at !== null);
    await desk.page.setViewportSize({ width: 900, height: 640 });
  });
  const first = { scale: 1, rotation: [1, 0, 0, 0], translation: [0, -0.5, -1.1] };

  test('controllers, floor and panel are drawn, and how long frames take is shown', async () => {
    await until(desk.page, () => window.palpateViewer.vr().frameTime > 0);
    const { drawn, floor, lines, panel } = await seen();
    assert.equal(panel, true);
    assert.deepEqual(drawn.map((n) => n > 0), [true, true]);
    assert.equal(floor, true);
    await until(desk.page, () => window.palpateViewer.vr().lines.some((line) => /^Frame \d+\.\d ms, longest \d+ ms$/.test(line)));
    assert.ok(lines.some((line) => /^Force/.test(line)) && lines.some((line) => /proxy, 500 N\/m/.test(line)), lines.join());
  });

  test('the trigger holds the tool at the controller, and it stays where it is let go', async () => {
    assert.equal(desk.gateway.poses.length, 0);
    await press('right', 'trigger', 1);
    await waitFor(() => desk.gateway.poses.length > 0, 'poses');
    await moveGripTo([0.05, 0.02, 0.2]);
    await press('right', 'trigger', 0);
    await until(desk.page, () => !window.palpateViewer.held);
    assert.ok(distance(desk.gateway.tool.position, [0.05, 0.02, 0.2]) < 3e-3);
    assert.equal(desk.gateway.parameters.demo, false);
  });

  test('contact is felt as a click, and the strength grows with the force', async () => {
    await press('right', 'trigger', 1);
    await waitFor(() => desk.gateway.poses.length > 0, 'poses');
    await moveGripTo([0, 0, 0.2]);
    const before = (await ask(desk.page, (v) => v.pulses)).length;
    const meanAt = async (depth) => {
      const from = (await ask(desk.page, (v) => v.pulses)).length;
      await moveGripTo([0, 0, radius + 0.02 - depth]);
      const newtons = desk.gateway.parameters.stiffness * depth;
      await desk.page.waitForFunction(([n, start]) => window.palpateViewer.pulses.slice(start)
        .filter((p) => p.kind === 'hum' && Math.abs(p.force - n) < 1.2).length > 2, [newtons, from]);
      const hums = (await ask(desk.page, (v) => v.pulses)).slice(from).filter((p) => p.kind === 'hum' && Math.abs(p.force - newtons) < 1.2);
      return hums.reduce((sum, p) => sum + p.intensity, 0) / hums.length;
    };
    const strengths = [await meanAt(0.004), await meanAt(0.01), await meanAt(0.018)];
    assert.equal((await ask(desk.page, (v) => v.pulses))[before].kind, 'click');
    assert.ok(strengths[0] < strengths[1] && strengths[1] < strengths[2], `${strengths}`);
    // The controller itself was asked for the last of them.
    const last = await desk.page.evaluate(() => {
      const gamepad = window.headset.controllers.right.inputSource.gamepad;
      const motor = gamepad.hapticActuators[0];
      const state = Object.getOwnPropertySymbols(motor).map((s) => motor[s]).find((v) => v?.lastPulse);
      return state.lastPulse.value;
    });
    assert.ok(Math.abs(last - strengths[2]) < 0.2, `${last}`);
    await moveGripTo([0, 0, 0.2]);
    const count = (await ask(desk.page, (v) => v.pulses)).length;
    await settle(desk.page, 4);
    assert.equal((await ask(desk.page, (v) => v.pulses)).length, count);
  });

  test('one hand holds the tool while the other moves the world', async () => {
    await press('right', 'trigger', 1);
    await until(desk.page, () => window.palpateViewer.held);
    await press('left', 'squeeze', 1);
    await settle(desk.page);
    await put('left', [resting.left[0] + 0.1, ...resting.left.slice(1)]);
    await settle(desk.page);
    await press('left', 'squeeze', 0);
    await waitFor(() => distance(room().translation, first.translation) > 0.05, 'a room');
    // The world went 0.1 m to the right with the hand: what was at the room's origin is now to its left.
    assert.ok(Math.abs(room().translation[0] - -0.1) < 1e-3, `${room().translation}`);
    assert.equal(room().scale, 1);
    assert.equal(await ask(desk.page, (v) => v.held), true);
  });

  test('two squeezes scale the world', async () => {
    await put('left', [-0.1, 1.2, -0.4]);
    await put('right', [0.1, 1.2, -0.4]);
    await settle(desk.page);
    await press('left', 'squeeze', 1);
    await press('right', 'squeeze', 1);
    await settle(desk.page);
    await put('left', [-0.2, 1.2, -0.4]);
    await put('right', [0.2, 1.2, -0.4]);
    await settle(desk.page);
    await press('left', 'squeeze', 0);
    await waitFor(() => room().scale !== 1, 'a scale');
    assert.ok(Math.abs(room().scale - 0.5) < 0.06, `${room().scale}`); // of the world in a metre of the room
  });

  test('the stick turns by 30 degrees and teleports, and it is dark for a moment', async () => {
    await stick(1, 0);
    await waitFor(() => Math.abs(room().rotation[0]) < 1, 'a turn');
    assert.ok(Math.abs(2 * Math.acos(room().rotation[0]) - Math.PI / 6) < 1e-6);
    await stick(0, 0);
    await until(desk.page, () => !window.palpateViewer.vr().dark);
    const before = room().translation;
    await stick(0, -1);
    await until(desk.page, () => window.palpateViewer.vr().aiming);
    await stick(0, 0);
    await waitFor(() => distance(room().translation, before) > 0.3, 'a place on the floor');
    assert.ok(Math.abs(room().translation[2] - before[2]) < 1e-9, 'the floor is as high as before');
    await until(desk.page, () => !window.palpateViewer.vr().aiming && !window.palpateViewer.vr().dark);
  });

  test('A stops and never resumes; a stop is seen; Resume on the panel resumes', async () => {
    await click('right', 'a-button');
    await waitFor(() => requests('emergency_stop').length === 1, 'a stop');
    await until(desk.page, () => window.palpateViewer.vr().stopFrame && /No force: emergency-stop/.test(window.palpateViewer.vr().lines[0]));
    await click('right', 'a-button');
    await waitFor(() => requests('emergency_stop').length === 2, 'another stop');
    assert.equal(requests('resume').length, 0);
    await pointAt('resume');
    await click('right', 'trigger');
    await waitFor(() => requests('resume').length === 1, 'resume');
    await until(desk.page, () => !window.palpateViewer.vr().stopFrame);
    assert.deepEqual(desk.gateway.poses, [], 'pressing a button takes no tool');
  });

  test('settings are changed on the panel', async () => {
    await pointAt('stiffer');
    await click('right', 'trigger');
    await waitFor(() => desk.gateway.parameters.stiffness === 625, 'stiffer');
    await pointAt('model');
    await click('right', 'trigger');
    await waitFor(() => desk.gateway.parameters.model === 'field', 'the next model');
  });

  test('a scene that somebody else opens is put within reach', async () => {
    desk.gateway.reset([0, 0, 0.3], ballScene(250)); // of which nobody has a room
    await until(desk.page, (kept) => window.palpateViewer.kept() === kept, desk.gateway.kept.length);
    await settle(desk.page);
    const above = [0, 0, 0.3];
    await put('right', inRoom(above));
    await settle(desk.page, 3);
    await press('right', 'trigger', 1);
    await waitFor(() => desk.gateway.poses.length > 0, 'poses');
    assert.ok(distance(await ask(desk.page, (v) => v.hand()), above) < 0.1, `${await ask(desk.page, (v) => v.hand())}`);
    await press('right', 'trigger', 0);
    await until(desk.page, () => !window.palpateViewer.held);
  });

  test('an arrow points to the tool when it is out of view', async () => {
    await until(desk.page, () => !window.palpateViewer.vr().marker);
    await look(Math.PI / 2); // to the left
    await until(desk.page, () => window.palpateViewer.vr().marker && window.palpateViewer.vr().pointsTo[0] > 0.1);
    await look(-Math.PI / 2);
    await until(desk.page, () => window.palpateViewer.vr().marker && window.palpateViewer.vr().pointsTo[0] < -0.1);
    await look(3); // where it is behind, nobody nods that far
    await until(desk.page, () => window.palpateViewer.vr().marker && Math.abs(window.palpateViewer.vr().pointsTo[1]) < 0.1);
  });

  test('tracked hands are drawn, the panel is at the left one, and a pinch holds the tool, which goes with the hand', async () => {
    const putHand = (hand, position) => desk.page.evaluate(([side, p]) => window.headset.hands[side].position.set(...p), [hand, position]);
    await desk.page.evaluate(() => { window.headset.primaryInputMode = 'hand'; });
    for (const side of ['left', 'right']) await putHand(side, resting[side]);
    await until(desk.page, () => Math.min(...window.palpateViewer.vr().drawn) > 20);
    await until(desk.page, () => window.palpateViewer.vr().panel);
    assert.ok(distance(await ask(desk.page, (v) => v.panelButton('stop')), resting.left) < 0.4);
    await desk.page.evaluate(() => window.headset.hands.right.updatePinchValue(1));
    await until(desk.page, () => window.palpateViewer.held);
    await settle(desk.page);
    const before = desk.gateway.tool.position;
    await putHand('right', resting.right.map((c, k) => c + [-0.1, 0.05, 0][k]));
    await waitFor(() => distance(desk.gateway.tool.position, [before[0] - 0.1, before[1], before[2] + 0.05]) < 0.01, 'the tool with the hand');
    await desk.page.evaluate(() => window.headset.hands.right.updatePinchValue(0));
    await until(desk.page, () => !window.palpateViewer.held);
    await desk.page.evaluate(() => { window.headset.primaryInputMode = 'controller'; });
    await until(desk.page, () => Math.max(...window.palpateViewer.vr().drawn) < 20 && Math.min(...window.palpateViewer.vr().drawn) > 0);
  });
});
