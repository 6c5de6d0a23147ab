// Another scene, from the page: picked, chosen or dropped; what cannot be read is refused with what to do.

import assert from 'node:assert/strict';
import { before, beforeEach, describe, test } from 'node:test';

import { ask, colorsOf, settle, until, waitFor } from './browser.mjs';
import { ball, clear, desk, frameAll, openDesk, requests, resetDesk } from './desk.mjs';
import { asciiOf } from './mock_scene.mjs';

const drop = (name, size) => desk.page.evaluate(([file, length]) => {
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([new Uint8Array(length)], file));
  for (const kind of ['dragover', 'drop']) window.dispatchEvent(new DragEvent(kind, { dataTransfer, bubbles: true, cancelable: true }));
}, [name, size]);

describe('another scene', () => {
  before(openDesk);
  beforeEach(() => resetDesk());

  test('is picked from what the program offers', async () => {
    await desk.page.keyboard.press('o');
    const dialog = desk.page.getByRole('dialog', { name: 'Open another scene' });
    await dialog.getByText('cup.spz').waitFor();
    assert.equal(await dialog.getByRole('button', { name: /cup.spz/ }).isDisabled(), true);
    await dialog.getByText('.spz cannot be read; convert it first').waitFor();
    await dialog.getByRole('button', { name: 'cup.ply 5.7 MB' }).click();
    await waitFor(() => requests('open_scene').length === 1, 'the scene');
    assert.equal(requests('open_scene')[0].args.data, '0/cup.ply');
    await dialog.waitFor({ state: 'hidden' });
    assert.equal(requests('emergency_stop').length, 0);
  });

  test('is shown how far it is, and what the program says against it', async () => {
    desk.gateway.change({ busy: 'opening cup.ply: reading 40 %' });
    await desk.page.getByText('Opening cup.ply: reading 40 %', { exact: true }).waitFor();
    assert.equal(await desk.page.locator('#progress-bar').evaluate((bar) => bar.value), 0.4);
    desk.gateway.change({ busy: '', message: 'cup.ply: byte 0: is no scene' });
    await desk.page.getByText('cup.ply: byte 0: is no scene').waitFor();
    assert.equal(await desk.page.locator('#progress').isVisible(), false);
  });

  test('is chosen as a file, or dropped, and handed over whole', async () => {
    await desk.page.locator('#scene-file').setInputFiles({ name: 'my cup.ply', mimeType: '', buffer: Buffer.alloc(300000) });
    await waitFor(() => desk.gateway.uploaded.length === 1, 'the file');
    await until(desk.page, () => document.getElementById('sending').hidden); // it takes one at a time
    await drop('cup.splat', 64);
    await waitFor(() => desk.gateway.uploaded.length === 2, 'the other');
    assert.deepEqual(desk.gateway.uploaded, [{ name: 'my cup.ply', bytes: 300000 }, { name: 'cup.splat', bytes: 64 }]);
    await until(desk.page, () => document.getElementById('sending').hidden);
  });

  test('that cannot be drawn is said once, is not asked for again, and the one before goes', async () => {
    const seen = async () => Math.max(...(await colorsOf(desk.page, [[0, 0, 0]]))[0]) - Math.min(...(await colorsOf(desk.page, [[0, 0, 0]]))[0]);
    assert.ok(await seen() > 60, 'the ball');
    desk.gateway.reset(clear, { ...ball, ply: asciiOf(ball) });
    await desk.page.getByText(/^scene-\d+\.ply can be felt, but not drawn: /).waitFor();
    assert.equal(await ask(desk.page, (v) => v.sceneLoaded), false);
    await new Promise((done) => { setTimeout(done, 3000); }); // longer than a retry would take
    assert.equal(desk.gateway.scenesSent, 1);
    assert.equal(await desk.page.locator('.notice').count(), 1);
    await settle(desk.page, 3);
    assert.ok(await seen() < 20, 'nothing');
    await resetDesk({ scene: { ...ball } });
    await frameAll();
  });

  test('of another format is not sent, but told how to convert; a refusal is shown', async () => {
    await drop('cup.spz', 64);
    await desk.page.getByText('npx @playcanvas/splat-transform cup.spz scene.ply').waitFor();
    await drop('cup.txt', 64);
    await desk.page.getByText('cup.txt is not a scene file').waitFor();
    desk.gateway.uploadRefusal = 'there is no room for it';
    await drop('cup.ply', 64);
    await desk.page.getByText('there is no room for it').waitFor();
    await settle(desk.page, 2);
    assert.deepEqual(desk.gateway.uploaded, []);
  });
});
