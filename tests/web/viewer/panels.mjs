// The panels: what they say is what is, and what is set in them is what the program is asked for.

import assert from 'node:assert/strict';
import { before, beforeEach, describe, test } from 'node:test';

import { ask, until, waitFor } from './browser.mjs';
import { desk, distance, field, openDesk, openSection, requests, resetDesk, touching } from './desk.mjs';
import { radius } from './mock_scene.mjs';

const enter = async (name, value) => {
  await field(name).fill(value);
  await field(name).press('Enter');
};
const shownValues = () => desk.page.evaluate(() => Object.fromEntries([...document.querySelectorAll('.plot-head')].map((head) =>
  [head.querySelector('h3').textContent, [...head.querySelectorAll('.value')].map((v) => v.textContent)])));

describe('panels', () => {
  before(openDesk);
  beforeEach(() => resetDesk());

  test('a stiffness that is typed changes the force', async () => {
    desk.gateway.tool.position = touching;
    const before = await until(desk.page, () => {
      const force = Math.hypot(...(window.palpateViewer.force() ?? [0]));
      return force > 1 && force;
    });
    await enter('stiffness', '1000');
    await until(desk.page, (b) => Math.abs(Math.hypot(...(window.palpateViewer.force() ?? [0])) - 2 * b) < 0.01 * b, before);
    assert.equal(await field('stiffness').inputValue(), '1000');
  });

  test('a refusal is shown, and the field goes back', async () => {
    desk.gateway.refusal = 'stiffness: above what the device can hold';
    await enter('stiffness', '4000');
    await desk.page.getByText('above what the device can hold').waitFor();
    await desk.page.locator('#canvas').focus();
    await desk.page.waitForFunction(() => document.querySelector('[data-field="stiffness"]').value === '500');
  });

  test('what cannot be is not asked for, but said', async () => {
    for (const [name, wrong, right, said] of [['stiffness', '6000', '500', /^Stiffness: .*5000/], ['friction', '', '0', /^Friction: .+/]]) {
      await enter(name, wrong);
      await desk.page.getByText(said).waitFor();
      assert.equal(await field(name).inputValue(), right);
    }
    assert.equal(requests('set_parameters').length, 0);
  });

  test('what another viewer changes is seen', async () => {
    desk.gateway.change({ model: 'density', friction: 0.3 });
    await desk.page.waitForFunction(() => document.querySelector('[data-field="model"]').value === 'density'
      && document.querySelector('[data-field="friction"]').value === '0.3');
  });

  test('the stiffness margin is a multiple in contact and nothing in free space', async () => {
    const margin = (text) => desk.page.waitForFunction((wanted) => [...document.querySelectorAll('.plot-head')]
      .find((head) => head.querySelector('h3').textContent === 'Stiffness margin').querySelector('.value').textContent === wanted, text);
    await margin('–');
    desk.gateway.tool.position = touching;
    await margin('3.2×');
    desk.gateway.margin = 0; // not known
    await margin('–');
  });

  test('mean and 99 % are of one time, and nothing is not magnified', async () => {
    const values = await shownValues();
    assert.deepEqual(values['Tick, 1 s'], ['22', '41']);
    const tops = await desk.page.evaluate(() => window.palpateViewer.plotTops());
    assert.ok(tops.Force >= 1 && tops.Contacts >= 5 && tops.Energy >= 1 && tops['Stiffness margin'] >= 2, JSON.stringify(tops));
  });

  test('an opacity cut of 1 says that no Gaussian can be touched', async () => {
    const said = desk.page.getByText('No touchable Gaussians');
    assert.equal(await said.count(), 0);
    await enter('opacity_min', '1');
    await said.waitFor();
    await enter('opacity_min', '0.1');
    await said.waitFor({ state: 'detached' });
  });

  test('what the terminal says is on the page', async () => {
    await openSection('Messages');
    await desk.page.getByText('omega (simulated)').waitFor();
    desk.gateway.say('2.100 s: no force: over-energy: <b>resume</b>');
    await desk.page.getByText('no force: over-energy: <b>resume</b>').waitFor();
    assert.equal(await desk.page.locator('#messages li').count(), 2);
  });

  test('a setup is proposed with its reasons, and taken or left', async () => {
    await openSection('Placement');
    await desk.page.getByRole('button', { name: 'Propose a setup' }).click();
    await desk.page.getByText('the median Gaussian is 7 times smaller').waitFor();
    await desk.page.getByText('Largest Gaussian: unchanged').waitFor();
    await desk.page.locator('.setup').getByRole('button', { name: 'Dismiss' }).click();
    assert.equal(requests('set_parameters').length, 0);
    await desk.page.getByRole('button', { name: 'Propose a setup' }).click();
    await desk.page.locator('.setup').getByRole('button', { name: 'Apply' }).click();
    await waitFor(() => requests('set_parameters').length === 1, 'the change');
    assert.deepEqual(JSON.parse(requests('set_parameters')[0].args.json), {
      registration: { frame: 'y-down', scale: 0.25 }, filter: { opacity_min: 0.2, crop_box: [-1, -1, -1, 1, 1, 1] },
    });
  });

  test('the scale has a slider', async () => {
    await openSection('Placement');
    await desk.page.getByRole('slider', { name: 'Scale' }).evaluate((node) => {
      node.value = 500;
      node.dispatchEvent(new Event('input'));
      node.dispatchEvent(new Event('change'));
    });
    await waitFor(() => Math.abs(desk.gateway.parameters.registration.scale - Math.sqrt(0.001 * 100)) < 0.01, 'the middle of its decades');
  });

  test('semi-axes are set in millimetres', async () => {
    await openSection('Tool');
    await enter('semi_axes-2', '55');
    await waitFor(() => desk.gateway.parameters.tool[0].semi_axes[2] === 0.055, 'the tool');
    assert.deepEqual(desk.gateway.parameters.tool[0].semi_axes.slice(0, 2), [0.02, 0.02]);
  });

  test('a tool file is sent as text', async () => {
    const toml = '[[ellipsoid]]\nname = "tip"\nsemi_axes = [0.01, 0.01, 0.01]\n';
    await field('tool_file').setInputFiles({ name: 'tip.toml', mimeType: 'application/toml', buffer: Buffer.from(toml) });
    await waitFor(() => requests('load_tool').length === 1, 'the file');
    assert.equal(requests('load_tool')[0].args.data, toml);
  });

  test('two clicked points and their distance give the scale', async () => {
    await openSection('Placement');
    const { forward, right, up } = await ask(desk.page, (v) => v.axes());
    const on = (x, y) => [0, 1, 2].map((k) => radius * (x * right[k] + y * up[k] - Math.sqrt(1 - x * x - y * y) * forward[k]));
    const points = [on(0.5, 0.1), on(-0.3, -0.4)];
    await desk.page.locator('[data-action=measure]').click();
    for (const point of points) await desk.page.mouse.click(...await ask(desk.page, (v, p) => v.project(p), point));
    await field('true_distance').fill(String(2000 * distance(...points)));
    await field('true_distance').press('Enter');
    await waitFor(() => desk.gateway.parameters.registration.scale !== 1, 'a scale');
    assert.ok(Math.abs(desk.gateway.parameters.registration.scale - 2) < 0.1, `${desk.gateway.parameters.registration.scale}`);
    assert.deepEqual(desk.gateway.poses, [], 'the clicks are the measurement’s');
  });

  test('frames, rotation and translation are set', async () => {
    await openSection('Placement');
    await desk.page.locator('[data-action=frame-y-down]').focus();
    await desk.page.keyboard.press('Enter');
    await desk.page.waitForFunction(() => document.activeElement.matches('[data-action=frame-y-down][aria-pressed=true]'));
    assert.equal(desk.gateway.parameters.registration.frame, 'y-down');
    await enter('rotation-2', '90');
    await waitFor(() => desk.gateway.parameters.registration.rotation[3] > 0.7, 'the rotation');
    assert.ok(distance(desk.gateway.parameters.registration.rotation, [Math.SQRT1_2, 0, 0, Math.SQRT1_2]) < 1e-6);
  });

  test('a recording is begun and ended, and a configuration taken along', async () => {
    await openSection('Recording and settings');
    const kept = desk.page.getByText('Kept until the next recording is complete');
    assert.equal(await kept.isVisible(), false);
    await desk.page.locator('[data-action=record]').click();
    await desk.page.getByRole('button', { name: 'Stop recording' }).click();
    await waitFor(() => requests('record').length === 2, 'both');
    assert.deepEqual(requests('record').map((r) => r.args.data), [true, false]);
    await kept.waitFor();
    assert.equal(await desk.page.getByRole('link', { name: 'as CSV' }).getAttribute('download'), 'recording.csv');
    const [download] = await Promise.all([desk.page.waitForEvent('download'), desk.page.locator('[data-action=config]').click()]);
    assert.equal(download.suggestedFilename(), 'palpate.toml');
  });
});
