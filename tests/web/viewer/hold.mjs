// The tool in the hand: brought, dragged, turned, held by keys, let go.

import assert from 'node:assert/strict';
import { before, beforeEach, describe, test } from 'node:test';

import { ask, settle, until, waitFor } from './browser.mjs';
import { clear, desk, distance, frameAll, openDesk, requests, resetDesk, scaled, textOf, toolOnPage } from './desk.mjs';
import { besideHaze, radius } from './mock_scene.mjs';

const felt = () => Math.hypot(...(window.palpateViewer.force() ?? [0])) > 0.1;
const middleOfView = async () => {
  const { x, y, width, height } = await desk.page.locator('#canvas').boundingBox();
  return [x + 0.5 * width, y + 0.5 * height];
};

describe('bringing the tool', () => {
  before(openDesk);
  beforeEach(() => resetDesk());

  test('a click on the surface brings it there, and it is felt: one action by mouse', async () => {
    const { forward, right } = await ask(desk.page, (v) => v.axes());
    const toCamera = scaled(forward, -1);
    const point = [0, 1, 2].map((k) => radius * (0.8 * toCamera[k] + 0.6 * right[k]));
    await desk.page.mouse.click(...await ask(desk.page, (v, p) => v.project(p), point));
    await until(desk.page, felt);
    await until(desk.page, () => !window.palpateViewer.approaching);
    const { position } = desk.gateway.tool;
    // From the camera's side, within the reach of the tool and of what it clicked on.
    const off = position.map((c, k) => c - point[k]);
    assert.ok(off.reduce((sum, c, k) => sum + c * toCamera[k], 0) > 0, 'on the side of the camera');
    assert.ok(Math.hypot(...off) < 0.045, `${Math.hypot(...off)} m from the point`);
    await desk.page.locator('#hint').waitFor({ state: 'hidden' }); // it has done its work
  });

  test('it goes around what is in its way', async () => {
    const { forward, right } = await ask(desk.page, (v) => v.axes());
    const [behind, beside] = [scaled(forward, 0.2), scaled(right, 0.08)]; // the ball, and the click
    desk.gateway.tool.position = behind.map((c, k) => c + beside[k]);
    await until(desk.page, (p) => Math.hypot(...window.palpateViewer.tool().map((c, k) => c - p[k])) < 1e-6, desk.gateway.tool.position);
    await desk.page.mouse.click(...await middleOfView());
    await until(desk.page, () => Math.hypot(...(window.palpateViewer.force() ?? [0])) > 0.1 && !window.palpateViewer.approaching);
    const nearestToMiddle = Math.min(...desk.gateway.poses.map(({ pose: { position: { x, y, z } } }) => Math.hypot(x, y, z)));
    assert.ok(nearestToMiddle > 0.8 * radius, `${nearestToMiddle} m from the middle of the ball`);
  });

  test('a click on what hides it brings it there; with Shift, it is caught where it is hidden', async () => {
    const { forward } = await ask(desk.page, (v) => v.axes());
    const hidden = scaled(forward, 0.2); // behind the ball, where its middle is seen
    desk.gateway.tool.position = hidden;
    await until(desk.page, (p) => Math.hypot(...window.palpateViewer.tool().map((c, k) => c - p[k])) < 1e-6, hidden);
    const at = await toolOnPage();
    await desk.page.mouse.move(...at);
    assert.equal(await desk.page.evaluate(() => document.getElementById('canvas').classList.contains('over-tool')), false);
    await desk.page.keyboard.down('Shift');
    await desk.page.mouse.down();
    await until(desk.page, () => window.palpateViewer.held && !window.palpateViewer.approaching);
    await desk.page.mouse.up();
    await desk.page.keyboard.up('Shift');
    await until(desk.page, () => !window.palpateViewer.held);
    assert.ok(distance(desk.gateway.tool.position, hidden) < 1e-6, 'it stays where it was caught');
    await desk.page.mouse.click(...at);
    await until(desk.page, () => Math.hypot(...(window.palpateViewer.force() ?? [0])) > 0.1 && !window.palpateViewer.approaching);
    const depth = desk.gateway.tool.position.reduce((sum, c, k) => sum + c * forward[k], 0);
    assert.ok(depth < -0.8 * radius, `${depth} m behind the middle of the ball`);
  });

  test('a key brings it to the middle of the view: one action by keyboard', async () => {
    await desk.page.keyboard.press('c');
    await until(desk.page, felt);
  });

  test('a key brings it past haze to what is solid', async () => {
    const place = [0.3, 0, 0];
    await resetDesk({ scene: besideHaze(place) });
    assert.ok(await ask(desk.page, (v, p) => v.pick(p), await middleOfView()), 'haze is seen in the middle');
    await desk.page.keyboard.press('c');
    await until(desk.page, () => window.palpateViewer.approaching);
    await until(desk.page, () => !window.palpateViewer.approaching);
    const off = distance(desk.gateway.tool.position, place);
    assert.ok(off < radius + 0.05, `${off} m from the ball`);
  });

  test('a click beside everything, or on what is cut off, brings it nowhere', async () => {
    await desk.page.mouse.click(20, 320);
    desk.gateway.change({ filter: { opacity_min: 0.99 } });
    await until(desk.page, () => window.palpateViewer.kept() === 0);
    await desk.page.mouse.click(...await middleOfView());
    await desk.page.getByText('The filter removes the Gaussians at this point').waitFor();
    assert.deepEqual(desk.gateway.poses, []);
  });

  test('a device that is somebody’s own is not brought anywhere', async () => {
    desk.gateway.change({ demo: undefined, device: { ...desk.gateway.parameters.device, kind: 'client' } });
    await until(desk.page, () => document.getElementById('demo').hidden);
    await desk.page.mouse.click(...await middleOfView());
    await settle(desk.page, 4);
    assert.deepEqual(desk.gateway.poses, []);
  });

  test('it is found by key and button', async () => {
    await desk.page.getByRole('button', { name: 'Find tool' }).click();
    const [x, y] = await middleOfView();
    await until(desk.page, ([cx, cy]) => {
      const at = window.palpateViewer.project(window.palpateViewer.tool());
      return Math.hypot(at[0] - cx, at[1] - cy) < 4;
    }, [x, y]);
    await frameAll();
    assert.ok(distance(await toolOnPage(), [x, y]) > 20);
  });

  test('a double click goes nearer and leaves the tool alone', async () => {
    const middle = await ask(desk.page, (v) => v.project([0, 0, 0]));
    const size = async () => {
      const [a, b] = await ask(desk.page, (v, r) => [v.project([0, 0, 0]), v.project(v.axes().right.map((c) => r * c))], radius);
      return distance(a, b);
    };
    const before = await size();
    await desk.page.mouse.dblclick(...middle);
    await settle(desk.page);
    assert.ok(await size() > 1.3 * before);
    assert.equal(await ask(desk.page, (v) => v.approaching), false);
    assert.ok(distance(desk.gateway.tool.position, clear) < 0.1, 'it has hardly begun');
    await frameAll();
  });
});

describe('holding the tool', () => {
  before(openDesk);
  beforeEach(() => resetDesk());

  test('the tool follows a drag and stays where it is let go', async () => {
    const [x, y] = (await toolOnPage()).map((c, k) => c + [3, -4][k]); // grabbed beside its middle
    await desk.page.mouse.move(x, y);
    await desk.page.waitForFunction(() => document.getElementById('canvas').classList.contains('over-tool'));
    await desk.page.mouse.down();
    await until(desk.page, () => window.palpateViewer.held);
    await desk.page.mouse.move(x + 60, y + 40, { steps: 4 });
    await until(desk.page, ([tx, ty]) => {
      const at = window.palpateViewer.project(window.palpateViewer.tool());
      return Math.hypot(at[0] - tx, at[1] - ty) < 3;
    }, [x + 57, y + 44]);
    await waitFor(() => desk.gateway.poses.length > 0, 'poses');
    assert.match(await textOf('holder'), /you hold the tool/);
    const { header, pose } = desk.gateway.poses.at(-1);
    assert.ok(Math.abs(header.stamp.secs - Date.now() / 1000) < 5 && header.stamp.nsecs < 1e9 && header.frame_id === 'world');
    assert.ok(Math.abs(Math.hypot(...Object.values(pose.orientation)) - 1) < 1e-9);
    await desk.page.mouse.up();
    assert.equal(await ask(desk.page, (v) => v.held), false);
    await waitFor(() => !desk.gateway.isHeld, 'the hand is free again'); // the last pose has come by then
    const sent = desk.gateway.poses.length;
    const left = desk.gateway.tool.position;
    assert.ok(distance(left, clear) > 0.02);
    await settle(desk.page, 4);
    await desk.page.waitForFunction(() => /stays where it is/.test(document.getElementById('holder').textContent));
    assert.equal(desk.gateway.poses.length, sent);
    assert.equal(desk.gateway.parameters.demo, false, 'and the demo does not take it');
    await desk.page.getByRole('button', { name: 'Start demo' }).click();
    await desk.page.getByRole('button', { name: 'Stop demo' }).click();
    await waitFor(() => requests('demo').length === 2, 'both');
    assert.deepEqual(requests('demo').map((r) => r.args.data), [true, false]);
  });

  test('Ctrl and a drag turn it where it is', async () => {
    const [x, y] = await toolOnPage();
    const before = { ...desk.gateway.tool };
    await desk.page.mouse.move(x, y);
    await desk.page.keyboard.down('Control');
    await desk.page.mouse.down();
    await desk.page.mouse.move(x + 80, y, { steps: 3 });
    await waitFor(() => distance(desk.gateway.tool.orientation, before.orientation) > 0.2, 'a turn');
    await desk.page.mouse.up();
    await desk.page.keyboard.up('Control');
    assert.ok(distance(desk.gateway.tool.position, before.position) < 1e-9);
    const { up } = await ask(desk.page, (v) => v.axes());
    const axis = desk.gateway.tool.orientation.slice(0, 3);
    assert.ok(distance(scaled(axis, 1 / Math.hypot(...axis)), up) < 1e-3, 'about the vertical of the screen');
  });

  test('keys move and turn it while Hold is on, and the wheel goes into depth', async () => {
    await desk.page.keyboard.press('h');
    await desk.page.keyboard.down('PageUp');
    await waitFor(() => distance(desk.gateway.tool.position, clear) > 0.01, 'a step by key');
    await desk.page.keyboard.up('PageUp');
    await desk.page.keyboard.down('d');
    await waitFor(() => distance(desk.gateway.tool.orientation, [0, 0, 0, 1]) > 0.1, 'a turn by key');
    await desk.page.keyboard.up('d');
    await settle(desk.page);
    const before = desk.gateway.tool.position;
    await desk.page.mouse.move(200, 300);
    await desk.page.mouse.wheel(0, 300); // towards the camera
    await waitFor(() => distance(desk.gateway.tool.position, before) > 0.01, 'a step by wheel');
    const { forward } = await ask(desk.page, (v) => v.axes());
    assert.ok(desk.gateway.tool.position.reduce((sum, c, k) => sum + (c - before[k]) * forward[k], 0) < 0);
    await desk.page.getByRole('button', { name: 'Hold' }).click();
    assert.equal(await ask(desk.page, (v) => v.held), false);
  });

  test('keys belong to an open dialog, also one that is pressed already', async () => {
    await desk.page.keyboard.press('h');
    await desk.page.keyboard.down('PageUp');
    await waitFor(() => distance(desk.gateway.tool.position, clear) > 0.01, 'a step by key');
    await desk.page.keyboard.press('?');
    await desk.page.getByRole('dialog').waitFor();
    await settle(desk.page);
    const before = await ask(desk.page, (v) => v.hand());
    await desk.page.keyboard.down('ArrowRight');
    await desk.page.keyboard.down('d');
    await settle(desk.page, 10);
    assert.deepEqual(await ask(desk.page, (v) => v.hand()), before);
    assert.equal(await ask(desk.page, (v) => v.held), true);
    for (const key of ['PageUp', 'ArrowRight', 'd', 'h']) await desk.page.keyboard.up(key);
    await desk.page.keyboard.press('Escape');
    await desk.page.getByRole('button', { name: 'Hold' }).click();
  });

  test('who is refused is told that someone else holds it', async () => {
    desk.gateway.refusePoses = true;
    await desk.page.getByRole('button', { name: 'Hold' }).click();
    await desk.page.waitForFunction(() => /someone else/.test(document.getElementById('holder').textContent));
    assert.equal(desk.gateway.poses.length, 0);
  });

  test('a drag beside the tool turns the view instead', async () => {
    const before = await toolOnPage();
    const drag = async (from, to) => {
      await desk.page.mouse.move(...from);
      await desk.page.mouse.down();
      await desk.page.mouse.move(...to, { steps: 3 });
      await desk.page.mouse.up();
    };
    await drag([60, 500], [160, 480]);
    assert.ok(distance(await toolOnPage(), before) > 5);
    await drag([160, 480], [60, 500]);
    assert.equal(desk.gateway.poses.length, 0);
  });

  test('the force is heard when that is asked for, and not else', async () => {
    desk.gateway.tool.position = [0, 0, radius + 0.012];
    await until(desk.page, felt);
    assert.deepEqual(await ask(desk.page, (v) => [v.sound.on, v.sound.level]), [false, 0]);
    await desk.page.keyboard.press('m');
    await until(desk.page, () => window.palpateViewer.sound.level > 0.2 && window.palpateViewer.sound.knocks > 0);
    const soft = await ask(desk.page, (v) => v.sound);
    assert.equal(soft.texture, 0, 'it does not slide');
    desk.gateway.velocity = [0.1, 0, 0];
    desk.gateway.change({ stiffness: 1500 });
    await until(desk.page, (level) => window.palpateViewer.sound.level > level && window.palpateViewer.sound.texture > 0.3, soft.level);
    desk.gateway.tool.position = clear;
    await until(desk.page, () => window.palpateViewer.sound.level === 0);
    await desk.page.getByRole('button', { name: 'Sound' }).click();
    assert.equal(await ask(desk.page, (v) => v.sound.on), false);
  });
});
