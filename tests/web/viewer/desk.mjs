// One page, one stand-in for the program, for all tests that use them: opening a page takes seconds, and each of these tests
// leaves nothing behind.

import assert from 'node:assert/strict';
import { after } from 'node:test';

import { ask, headsetScript, launch, openViewer, settle, until } from './browser.mjs';
import { MockGateway } from './mock_gateway.mjs';
import { ballScene, radius } from './mock_scene.mjs';

export const folder = process.env.VIEWER_FOLDER;
export const clear = [0, 0, 0.2]; // where the tool touches nothing
export const touching = [0, 0, radius + 0.012]; // the mock's tool is 8 mm deep there
export const distance = (a, b) => Math.hypot(...a.map((c, k) => c - b[k]));
export const scaled = (v, by) => v.map((c) => c * by);
export const ball = ballScene(600);

export const desk = { browser: null, gateway: null, page: null, problems: [] };

/// Opens the page, once. It has a headset, which does nothing until it is entered.
export async function openDesk() {
  if (desk.page) return;
  desk.browser = await launch();
  desk.gateway = await new MockGateway(folder, ball).start();
  desk.gateway.tool.position = clear;
  Object.assign(desk, await openViewer(desk.browser, desk.gateway.url, { script: await headsetScript() }));
}

/// As it was, but for where the view looks from: another scene, if it is given.
export async function resetDesk({ scene = ball, at = clear, parameters = {} } = {}) {
  const { page, gateway } = desk;
  await page.evaluate(() => {
    document.activeElement.blur();
    document.querySelector('dialog[open]')?.close();
    for (const node of document.querySelectorAll('.notice button')) node.click();
    window.dispatchEvent(new Event('blur')); // lets the tool go
  });
  const other = scene !== desk.scene;
  desk.scene = scene;
  gateway.reset(at, scene, parameters);
  await page.waitForFunction(() => document.getElementById('pause').textContent === 'Pause');
  await page.locator('#stopped').waitFor({ state: 'hidden' }); // of the test before
  await until(page, ([stiffness, z, kept]) => {
    const viewer = window.palpateViewer;
    return viewer.connected && viewer.parameters().stiffness === stiffness && !viewer.held && viewer.tool()?.[2] === z && viewer.sceneLoaded && viewer.kept() === kept;
  }, [gateway.parameters.stiffness, at[2], gateway.kept.length]);
  if (other) await frameAll();
}

export async function frameAll() {
  await desk.page.getByRole('button', { name: 'Frame all' }).click();
  await settle(desk.page, 8); // drawn as soon as it is sorted
}

export const requests = (name) => desk.gateway.requests.filter((r) => r.service === `/palpate/${name}`);
export const field = (name) => desk.page.locator(`[data-field="${name}"]`).first();
export const toolOnPage = () => ask(desk.page, (v) => v.project(v.tool()));
export const textOf = (id) => desk.page.evaluate((i) => document.getElementById(i).textContent, id);
export const openSection = (title) => desk.page.evaluate((text) => {
  [...document.querySelectorAll('details')].find((d) => d.querySelector('summary').textContent === text).open = true;
}, title);

after(async () => {
  await desk.browser?.close();
  await desk.gateway?.stop();
  assert.deepEqual(desk.problems, []);
});
