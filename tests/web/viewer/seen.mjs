// What is seen: the scene, what can be felt of it, contacts, forces, how deep the tool is.

import assert from 'node:assert/strict';
import { before, beforeEach, describe, test } from 'node:test';

import { ask, colorsOf, settle, until } from './browser.mjs';
import { ball, clear, desk, distance, frameAll, openDesk, resetDesk, scaled, toolOnPage, touching } from './desk.mjs';
import { ballScene, radius } from './mock_scene.mjs';

const spread = (color) => Math.max(...color) - Math.min(...color);

/// The labels that are shown at the tool: {text, box}.
const labels = () => desk.page.evaluate(() => [...document.querySelectorAll('.tool-name, .tool-distance')]
  .map((one) => ({ text: one.textContent, box: one.getBoundingClientRect().toJSON() })).filter(({ box }) => box.width > 0));

describe('what is seen', () => {
  before(openDesk);
  beforeEach(() => resetDesk());

  test('the page opens on the object', async () => {
    const [left, right, top, bottom] = await ask(desk.page, (v, r) => {
      const { right: x, up: y } = v.axes();
      return [x.map((c) => -r * c), x.map((c) => r * c), y.map((c) => r * c), y.map((c) => -r * c)].map((p) => v.project(p));
    }, radius);
    const { width, height } = await desk.page.locator('#canvas').boundingBox();
    for (const [x, y] of [left, right, top, bottom]) assert.ok(x > 0 && y > 0 && x < width && y < height);
    assert.ok(bottom[1] - top[1] > 0.2 * height, `${bottom[1] - top[1]} of ${height} px`);
    const { y, height: bar } = await desk.page.locator('.bar-row').boundingBox();
    assert.ok(top[1] > y + bar, 'below the toolbar');
  });

  test('the object is in the middle, however near the tool is, which is in view if it is', async () => {
    const framed = async (tool) => {
      desk.gateway.tool.position = tool;
      await until(desk.page, (at) => window.palpateViewer.tool().every((c, k) => Math.abs(c - at[k]) < 1e-9), tool);
      await frameAll();
      const [left, right, at] = await ask(desk.page, (v, r) => [...[-r, r].map((side) => v.axes().right.map((c) => side * c)), v.tool()].map((p) => v.project(p)), radius);
      return { middle: 0.5 * (left[0] + right[0]), height: left[1], size: right[0] - left[0], at };
    };
    const { x, y, width, height } = await desk.page.locator('#canvas').boundingBox();
    const isSeen = (at) => at && at[0] > x && at[0] < x + width && at[1] > y && at[1] < y + height;
    const { right, up } = await ask(desk.page, (v) => v.axes());
    const here = await framed([0, 0, 0]);
    const beside = await framed(scaled(right, 0.27));
    const below = await framed(scaled(up, -0.2));
    const far = await framed(scaled(right, 1.5));
    for (const view of [here, beside, below, far]) {
      assert.ok(Math.abs(view.middle - x - 0.5 * width) < 0.02 * width, `${view.middle} of ${width} px`);
      assert.ok(Math.abs(view.height - here.height) < 0.02 * height, `${view.height} and ${here.height}`);
    }
    for (const { at, size } of [beside, below]) {
      assert.ok(isSeen(at), `${at}`);
      assert.ok(size < 0.99 * here.size && size > 0.5 * here.size, `${size} and ${here.size}`);
    }
    assert.ok(Math.abs(far.size - here.size) < 1, 'it is not made small for a tool that is far away');
    assert.ok(!isSeen(far.at));
    desk.gateway.tool.position = clear;
  });

  test('the scene is where the program says, in the colours of the file', async () => {
    const { right } = await ask(desk.page, (v) => v.axes());
    // Along the camera's right, just inside and just outside the outline of the ball.
    const seen = await colorsOf(desk.page, [0.9, -0.9, -1.15, 1.15].map((share) => scaled(right, share * radius)));
    assert.ok(seen[0][0] > seen[0][2] + 60, `orange, not ${seen[0]}`);
    assert.ok(seen[1][2] > seen[1][0] + 60, `blue, not ${seen[1]}`);
    for (const color of seen.slice(2)) assert.ok(spread(color) < 20, `background, not ${color}`);
  });

  test('a registration moves and scales the scene', async () => {
    desk.gateway.change({ registration: { scale: 0.5, translation: [0.5, 0, 0] } });
    await until(desk.page, () => window.palpateViewer.parameters().registration.scale === 0.5);
    await frameAll();
    const [moved, before] = await colorsOf(desk.page, [[0.54, -0.029, 0], [0, -radius, 0]]);
    assert.ok(moved[0] > moved[2] + 60, `orange, not ${moved}`);
    assert.ok(spread(before) < 20, `background, not ${before}`);
    desk.gateway.change({ registration: { scale: 1, translation: [0, 0, 0] } });
    await until(desk.page, () => window.palpateViewer.parameters().registration.scale === 1);
    await frameAll();
  });

  test('what can be felt is what the opacity cut keeps, and is drawn when asked for', async () => {
    const faint = ball.gaussians.filter((g) => g.opacity < 0.1).length;
    const kept = ball.gaussians.length - faint;
    assert.equal(await ask(desk.page, (v) => v.kept()), kept);
    assert.equal(await ask(desk.page, (v) => v.felt()), 0);
    await desk.page.locator('[data-toggle=felt]').check();
    await until(desk.page, (n) => window.palpateViewer.felt() === n, kept);
    desk.gateway.change({ filter: { opacity_min: 0.01 } });
    await until(desk.page, (n) => window.palpateViewer.felt() === n, ball.gaussians.length);
    await desk.page.locator('[data-toggle=felt]').uncheck();
  });

  test('scenes that are switched before they have come are let go, and the last one comes', async () => {
    desk.gateway.stalls = true;
    for (let k = 0; k < 7; k += 1) { // more than there are workers to read them
      desk.gateway.reset(clear, ballScene(200 + k));
      desk.gateway.stalls = true;
      await until(desk.page, (name) => window.palpateViewer.parameters().scene.name === name, desk.gateway.parameters.scene.name);
      await settle(desk.page, 1);
    }
    desk.gateway.stalls = false;
    await until(desk.page, (kept) => window.palpateViewer.sceneLoaded && window.palpateViewer.kept() === kept, desk.gateway.kept.length);
    assert.equal(await desk.page.locator('.notice').count(), 0);
    await resetDesk();
    await frameAll();
  });

  test('the scene comes back when the graphics card has lost it', async () => {
    const become = async (is) => {
      for (let k = 0; (spread((await colorsOf(desk.page, [[0, -radius, 0]]))[0]) > 60) !== is; k += 1) {
        assert.ok(k < 100, `the ball is ${is ? 'not ' : ''}seen`);
        await settle(desk.page, 1);
      }
    };
    await become(true);
    await desk.page.evaluate(() => {
      window.loss = document.getElementById('canvas').getContext('webgl2').getExtension('WEBGL_lose_context');
      window.loss.loseContext();
    });
    await become(false);
    await desk.page.evaluate(() => window.loss.restoreContext());
    await become(true);
  });

  test('contacts light up where they are, with a ring at the deepest, and go out', async () => {
    desk.gateway.tool.position = touching;
    const expected = desk.gateway.contacts;
    const drawn = await until(desk.page, (n) => { // at one instant: on a busy machine they may go out in between
      const v = window.palpateViewer;
      return v.drawnContacts() === n && v.cue() === 'contact' && v.contacts().map((c) => ({ ...c, drawn: v.centreOfDrawnContact(c.id) }));
    }, expected.length);
    for (const { row, center, scale } of expected) {
      const one = drawn.find((c) => c.id === row);
      assert.ok(distance(one.drawn, center) < 1e-4, `contact ${row} is drawn ${distance(one.drawn, center)} m away`);
      assert.ok(distance(one.scale, scale) < 1e-9);
    }
    desk.gateway.tool.position = clear;
    await until(desk.page, () => window.palpateViewer.drawnContacts() === 0 && window.palpateViewer.cue() === 'gap');
  });

  test('the line to the surface is as long as the gap is, and is labelled where no other label is', async () => {
    for (const height of [0.4, 0.3, 0.24, 0.2]) {
      desk.gateway.tool.position = [0, 0, height];
      const longest = desk.gateway.parameters.tool[0].semi_axes[2]; // along z
      await until(desk.page, (gap) => Math.abs((window.palpateViewer.gap ?? 0) - gap) < 0.004, height - longest - radius);
      await settle(desk.page, 3);
      const shown = await labels();
      const [a, b] = shown.map(({ box }) => box);
      assert.ok(!b || a.right < b.left || b.right < a.left || a.bottom < b.top || b.bottom < a.top, JSON.stringify(shown));
    }
    assert.ok((await labels()).some(({ text }) => /^(Tool, )?(8(\.\d)?|7\.\d) cm$/.test(text)));
  });

  test('the arrow points where the force does', async () => {
    desk.gateway.tool.position = [0.06, -0.06, 0.06];
    const arrow = await until(desk.page, () => window.palpateViewer.arrow());
    const outward = scaled(desk.gateway.tool.position, 1 / Math.hypot(...desk.gateway.tool.position));
    assert.ok(distance(arrow, outward) < 1e-3, `${arrow}`);
  });

  test('where the tool is far too small for the scene, that is said', async () => {
    const tool = [{ ...desk.gateway.parameters.tool[0], semi_axes: [5e-4, 5e-4, 5e-4] }];
    await resetDesk({ scene: ballScene(300), parameters: { tool } });
    await desk.page.getByText('times smaller than the scene').waitFor();
  });

  test('a tool that is small is encircled by 24 pixels at least, and one out of view is pointed at', async () => {
    desk.gateway.change({ tool: [{ ...desk.gateway.parameters.tool[0], semi_axes: [0.002, 0.002, 0.002] }] });
    // At one instant: where a busy machine says nothing for a while, there is no mark.
    const shown = (mark) => until(desk.page, (selector) => {
      const { x, y, width, height } = document.querySelector(selector).getBoundingClientRect();
      return width > 0 && { x, y, width, height };
    }, mark);
    const { x, y, width } = await shown('.tool-ring');
    const at = await toolOnPage();
    assert.ok(width >= 24, `${width} px`);
    assert.ok(distance([x + 0.5 * width, y + 0.5 * width], at) < 3);
    desk.gateway.tool.position = [0, 0, 3];
    const arrow = await shown('.tool-arrow');
    assert.equal(await desk.page.locator('.tool-ring').isVisible(), false);
    assert.ok(arrow.width >= 24 || arrow.height >= 24, `${arrow.width} by ${arrow.height} px`);
    const { width: w, height: h } = await desk.page.locator('#canvas').boundingBox();
    assert.ok(arrow.x > 0 && arrow.x + arrow.width < w && arrow.y > 0 && arrow.y + arrow.height < h, 'in the view');
    assert.ok(arrow.y < 0.3 * h, 'the tool is above');
    await desk.page.keyboard.press('t');
    await until(desk.page, () => {
      const tool = window.palpateViewer.project(window.palpateViewer.tool());
      const canvas = document.getElementById('canvas').getBoundingClientRect();
      return tool && Math.hypot(tool[0] - 0.5 * canvas.width, tool[1] - 0.5 * canvas.height) < 5;
    });
    desk.gateway.tool.position = clear;
    await settle(desk.page, 3);
    await frameAll();
  });

  test('a tool that the page lies on is pointed at', async () => {
    await desk.page.evaluate(() => { document.getElementById('hint').hidden = false; });
    const hint = await desk.page.locator('#hint').boundingBox();
    const [origin, above, up] = await ask(desk.page, (v) => [v.project([0, 0, 0]), v.project(v.axes().up.map((c) => 0.1 * c)), v.axes().up]);
    const below = hint.y + 0.5 * hint.height - origin[1];
    desk.gateway.tool.position = scaled(up, (-0.1 * below) / (origin[1] - above[1]));
    const arrow = await until(desk.page, () => {
      const { x, width, bottom } = document.querySelector('.tool-arrow').getBoundingClientRect();
      return width > 0 && { x, bottom };
    });
    assert.ok(arrow.bottom < hint.y && arrow.x > hint.x, `${arrow.x}, ${arrow.bottom}`);
    await desk.page.evaluate(() => { document.getElementById('hint').hidden = true; });
    await until(desk.page, () => document.querySelector('.tool-arrow').getBoundingClientRect().width === 0);
    desk.gateway.tool.position = clear;
    await settle(desk.page, 3);
  });
});
