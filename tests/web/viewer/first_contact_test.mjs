// Real captures, of which nothing is known: every .ply and .splat in the folder PALPATE_SCENES. From page load to a felt contact
// by one action, whatever their unit. Needs PALPATE_BINARY.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { cp, mkdtemp, readdir, rm, symlink } from 'node:fs/promises';
import os from 'node:os';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';

import { ask, launch, openViewer, settle, until } from './browser.mjs';

const folder = process.env.PALPATE_SCENES;
const long = 600000; // software draws millions of splats slowly. Unit: [ms].
const least = 24; // that marks the tool. Unit: [px].
const stays = Number(process.env.STAYS ?? 30000); // Unit: [ms].

const files = (await readdir(folder)).filter((name) => /\.(ply|splat)$/.test(name) && !name.includes('compressed'));

async function run(scene) {
  const program = spawn(process.env.PALPATE_BINARY, ['run', scene, '--port', '0'], { stdio: ['ignore', 'ignore', 'pipe'] });
  const url = await new Promise((found, failed) => {
    let said = '';
    program.stderr.on('data', (data) => {
      said += data;
      const at = /take part: (\S+)/.exec(said);
      if (at) found(at[1]);
    });
    program.on('exit', () => failed(new Error(said)));
  });
  return { url, stop: () => new Promise((done) => { program.on('exit', done); program.kill('SIGINT'); }) };
}

for (const name of files) {
  describe(name, () => {
    let browser, program, page, work;
    const felt = () => until(page, () => Math.hypot(...(window.palpateViewer.force() ?? [0])) > 0.05 && !window.palpateViewer.approaching);
    const free = async () => {
      await page.getByRole('button', { name: 'Start demo' }).click();
      await until(page, () => window.palpateViewer.parameters().demo);
    };

    before(async () => {
      // The index goes beside a link, not into somebody's folder.
      work = await mkdtemp(path.join(os.tmpdir(), 'palpate-captures-'));
      await symlink(path.join(folder, name), path.join(work, name)).catch(() => cp(path.join(folder, name), path.join(work, name)));
      browser = await launch();
      program = await run(path.join(work, name));
      const context = { viewport: { width: 1440, height: 900 }, deviceScaleFactor: 0.25 };
      ({ page } = await openViewer(browser, program.url, { context, patience: long }));
      page.setDefaultTimeout(long);
      await until(page, () => !window.palpateViewer.parameters().registration.assumed.includes('scale')
        && !window.palpateViewer.parameters().busy);
      await settle(page, 4);
    }, { timeout: long });
    after(async () => {
      await browser?.close();
      await program?.stop();
      await rm(work, { recursive: true, force: true });
    });

    test('the tool is marked at first sight', async () => {
      const marked = () => page.locator('.tool-ring, .tool-arrow').evaluateAll((nodes) => Math.max(0, ...nodes.map((n) => n.getBoundingClientRect().width)));
      await until(page, () => window.palpateViewer.fresh('measured_cp'));
      await settle(page, 2);
      const size = Math.max(await ask(page, (v) => v.toolPixels()), await marked());
      assert.ok(size >= least, `${size} px`);
    });

    test('by keyboard: one key, and it is felt', { timeout: long }, async () => {
      await page.keyboard.press('c');
      await felt();
      await free();
    });

    test('by mouse: one click, it is felt, and the tool stays where it is left', { timeout: long }, async () => {
      const { x, y, width, height } = await page.locator('#canvas').boundingBox();
      const places = [0, 40, -40, 80, -80, 140].flatMap((dx) => [0, 40, -40, 80].map((dy) => [x + 0.5 * width + dx, y + 0.5 * height + dy]));
      const place = await ask(page, (v, list) => list.find((p) => v.pick(p)), places);
      assert.ok(place, 'something is seen near the middle');
      await page.mouse.click(...place);
      await felt();
      await page.waitForTimeout(2000); // it settles in what it is pressed into
      const left = await ask(page, (v) => v.tool());
      await page.waitForTimeout(stays);
      const [now, size] = await ask(page, (v) => [v.tool(), v.parameters().tool[0].semi_axes[0]]);
      assert.ok(Math.hypot(...now.map((c, k) => c - left[k])) < size, `${left} and ${now}`);
    });
  });
}
