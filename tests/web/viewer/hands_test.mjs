// The viewer page of a program with several hands: it shows all, and is for the one that its address names. Needs PALPATE_BINARY.

import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';

import { ask, launch, openViewer, until } from './browser.mjs';
import { Program } from './program.mjs';

const above = [0, 0, 0.3]; // where the first hand's tool waits
const aside = [0.1, 0, 0.3]; // the other's

let browser;
let program;

before(async () => {
  browser = await launch();
  program = await Program.create();
  const file = path.join(program.folder, 'left.toml');
  const waiting = path.join(program.folder, 'left.csv');
  await writeFile(waiting, `t,x,y,z\n0,${aside}\n60,${aside}\n`);
  await writeFile(file, `tool = [0.01, 0.01, 0.01]\ntrajectory = "${waiting}"\n`);
  await program.start(above, ['--hands', `left=${file}`]);
});
after(async () => {
  await program?.stop();
  await program?.remove();
  await browser?.close();
});

const legendOf = (page) => page.locator('#legend').textContent();

describe('with two hands', () => {
  test('the page is for the first, and shows the other', async () => {
    const { page, problems } = await openViewer(browser, program.url);
    await until(page, () => window.palpateViewer.others().length === 1 && window.palpateViewer.drawnOthers() === 1);
    const [other] = await ask(page, (v) => v.others());
    assert.equal(other.name, 'left');
    assert.deepEqual(other.parts[0].semiAxes, [0.01, 0.01, 0.01]);
    assert.ok(Math.hypot(...other.parts[0].position.map((c, k) => c - aside[k])) < 0.01, JSON.stringify(other));
    await until(page, () => /left 0\.0 N/.test(document.getElementById('legend').textContent));
    assert.deepEqual(problems, []);
    await page.close();
  });

  test('the page of the other is for that', async () => {
    const { page, problems } = await openViewer(browser, `${program.url}?hand=left`);
    await until(page, () => window.palpateViewer.drawnOthers() === 1);
    assert.equal((await ask(page, (v) => v.parameters())).hand, 'left');
    assert.deepEqual((await ask(page, (v) => v.others())).map(({ name }) => name), ['']);
    assert.match(await legendOf(page), /first hand/);
    assert.equal(await page.locator('#hand-name').textContent(), 'hand left');
    assert.match(await page.title(), /^hand left · ball\.ply/);
    await page.locator('#stop').click();
    await until(page, () => document.title.startsWith('Stopped · hand left'));
    const first = await openViewer(browser, program.url);
    assert.ok(!(await first.page.title()).startsWith('Stopped'));
    assert.equal(await first.page.locator('#hand-name').isVisible(), false);
    assert.deepEqual([...problems, ...first.problems], []);
  });

  test('a page for a hand that there is not shows those that there are, and nothing else', async () => {
    for (const name of ['nosuch', 'Left', '../left']) {
      const page = await browser.newPage();
      await page.goto(`${program.url}?hand=${encodeURIComponent(name)}`);
      await page.getByText(`This program has no hand “${name}”`).waitFor();
      assert.deepEqual(await page.locator('#unknown-hand a').allTextContents(), ['the first hand', 'left']);
      for (const id of ['stop', 'canvas', 'panels']) assert.equal(await page.locator(`#${id}`).isVisible(), false, id);
      await page.getByRole('link', { name: 'left' }).click();
      await page.waitForFunction(() => document.getElementById('hand-name').textContent === 'hand left');
      await page.close();
    }
  });
});
