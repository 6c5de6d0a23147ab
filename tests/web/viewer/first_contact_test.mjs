// From page load to the first felt contact, counted in actions, on scenes of which nothing is known: the built-in one, and every
// .ply and .splat in the folder PALPATE_SCENES. Needs PALPATE_BINARY.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { cp, mkdtemp, readdir, rm, symlink } from 'node:fs/promises';
import os from 'node:os';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';

import { ask, launch, openViewer, settle, until } from './browser.mjs';
import { countHeldUp } from './program.mjs';

const folder = process.env.PALPATE_SCENES;
const long = Number(process.env.PATIENCE ?? 600000); // software draws millions of splats slowly. Unit: [ms].
const least = 24; // that marks the tool. Unit: [px].
const stays = Number(process.env.STAYS ?? 30000); // Unit: [ms].
const most = { mouse: 2, keyboard: 3, touch: 2 }; // actions
const mostTries = 5;

const desk = { viewport: { width: 1440, height: 900 }, deviceScaleFactor: 0.25 };
const phone = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 0.5, hasTouch: true, isMobile: true };
const files = folder ? (await readdir(folder)).filter((name) => /\.(ply|splat)$/.test(name) && !name.includes('compressed')) : [];
const builtIn = 'the built-in scene';

async function run(args) {
  const program = spawn(process.env.PALPATE_BINARY, ['run', ...args, '--port', '0'], { stdio: ['ignore', 'ignore', 'pipe'] });
  const url = await new Promise((found, failed) => {
    let said = '';
    program.stderr.on('data', (data) => {
      said += data;
      const at = /viewer: (\S+)/.exec(said);
      if (at) found(at[1]);
    });
    program.on('exit', () => failed(new Error(said)));
  });
  return { url, stop: () => new Promise((done) => { program.on('exit', done); program.kill('SIGINT'); }) };
}

for (const name of [builtIn, ...files]) {
  describe(name, () => {
    let browser, program, work;

    // A page that has just been loaded, at the size that it has found for the scene.
    async function load(context) {
      const { page } = await openViewer(browser, program.url, { context, patience: long });
      page.setDefaultTimeout(long);
      await until(page, () => !window.palpateViewer.parameters().registration.assumed.includes('scale')
        && !window.palpateViewer.parameters().busy);
      await settle(page);
      return page;
    }

    // The force is on: on a busy machine the demo may have lost it.
    async function forceComesOn(page) {
      const look = () => (document.getElementById('state').textContent === 'active' && 'on') || (!document.getElementById('resume').hidden && 'stopped');
      while (await until(page, look) === 'stopped') await page.evaluate(() => document.getElementById('resume').click());
    }

    // What the tool does after `act`, which counts what it does, on a page of its own: {page, felt, said}, not felt where the program
    // was held up meanwhile.
    async function attempt(by, context, act) {
      const page = await load(context);
      const outline = await until(page, (size) => { // or by a mark, once it is known where the tool is
        const width = Math.max(window.palpateViewer.toolPixels(),
          ...[...document.querySelectorAll('.tool-ring, .tool-arrow')].map((mark) => mark.getBoundingClientRect().width));
        return width >= size && width;
      }, least);
      await forceComesOn(page);
      const heldUp = await page.evaluate(countHeldUp);
      let actions = 0;
      const way = await act(page, (action) => { ++actions; return action; }) ?? 0;
      assert.ok(actions <= most[by], `${actions} actions by ${by}`);
      const said = `${actions} by ${by}, ${way.toFixed(0)} px from the middle of the view; the tool's outline is ${outline.toFixed(0)} px wide`;
      // One function: the page's own rules forbid to make functions of text there.
      const { felt } = await until(page, new Function('before', `
        if ((${countHeldUp})() > before) return { felt: false };
        const viewer = window.palpateViewer;
        const { demo } = viewer.parameters(); // which touches things, too
        return !demo && Math.hypot(...(viewer.force() ?? [0])) > 0.05 && !viewer.approaching && { felt: true };`), heldUp);
      return { page, felt, said };
    }

    // Tries until it is felt and `then` says what it saw, which is null where the program was held up; `t`, the test, says what it took.
    async function feel(t, by, context, act, then = () => '') {
      for (let tries = 1; ; ++tries) {
        const { page, felt, said } = await attempt(by, context, act);
        const more = felt ? await then(page) : null;
        await page.getByRole('button', { name: 'Start demo' }).click();
        await until(page, () => window.palpateViewer.parameters().demo);
        await page.close();
        if (more !== null) {
          t.diagnostic(`${name}: ${said}${more}`);
          return;
        }
        assert.ok(tries < mostTries, 'the program was held up');
      }
    }

    // As near to the middle of the view as somebody sees a thing, and no haze: {place, way}, and how far from the middle.
    async function seenPlace(page) {
      const { x, y, width, height } = await page.locator('#canvas').boundingBox();
      const steps = [-8, -7, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7, 8].map((k) => k / 20);
      const places = steps.flatMap((a) => steps.map((b) => [a * width, b * height])).sort((p, q) => Math.hypot(...p) - Math.hypot(...q))
        .map(([dx, dy]) => [x + 0.5 * width + dx, y + 0.5 * height + dy]);
      const place = await ask(page, (v, list) => list.find((p) => document.elementFromPoint(...p)?.id === 'canvas' && v.pick(p)
        && v.seenOpacity(p) > 0.8), places);
      assert.ok(place, 'something is seen');
      return { place, way: Math.hypot(place[0] - x - 0.5 * width, place[1] - y - 0.5 * height) };
    }

    async function staysWhereItIsLeft(page) {
      const heldUp = await page.evaluate(countHeldUp);
      await page.waitForTimeout(2000); // it settles in what it is pressed into
      const left = await ask(page, (v) => v.tool());
      await page.waitForTimeout(stays);
      const [now, size] = await ask(page, (v) => [v.tool(), v.parameters().tool[0].semi_axes[0]]);
      if (await page.evaluate(countHeldUp) > heldUp) return null; // nothing pushes against the hand any more
      const moved = Math.hypot(...now.map((c, k) => c - left[k]));
      assert.ok(moved < size, `${left} and ${now}`);
      return `; it moves ${(1000 * moved).toFixed(1)} mm in ${stays / 1000} s`;
    }

    before(async () => {
      // The index goes beside a link, not into somebody's folder.
      work = await mkdtemp(path.join(os.tmpdir(), 'palpate-first-contact-'));
      const scene = path.join(work, name);
      if (name !== builtIn) await symlink(path.join(folder, name), scene).catch(() => cp(path.join(folder, name), scene));
      browser = await launch();
      program = await run(name === builtIn ? [] : [scene]);
    }, { timeout: long });
    after(async () => {
      await browser?.close();
      await program?.stop();
      await rm(work, { recursive: true, force: true });
    });

    test('by keyboard', { timeout: long }, (t) => feel(t, 'keyboard', desk, (page, count) => count(page.keyboard.press('c'))));

    test('by mouse, and the tool stays where it is left', { timeout: long }, (t) => feel(t, 'mouse', desk, async (page, count) => {
      const { place, way } = await seenPlace(page);
      await count(page.mouse.click(...place));
      return way;
    }, staysWhereItIsLeft));

    test('by touch', { timeout: long }, (t) => feel(t, 'touch', phone, async (page, count) => {
      const { place, way } = await seenPlace(page);
      await count(page.touchscreen.tap(...place));
      return way;
    }));
  });
}
