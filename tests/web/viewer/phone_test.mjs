// The page on a phone, by touch, upright and lying; how its parts lie on any screen; and what every eye, hand and reader needs:
// contrast, names, keys, no motion.

import assert from 'node:assert/strict';
import { after, before, beforeEach, describe, test } from 'node:test';

import { ask, launch, openViewer, settle, until, waitFor } from './browser.mjs';
import { MockGateway } from './mock_gateway.mjs';
import { ballScene } from './mock_scene.mjs';

const upright = { width: 390, height: 844 };
const lying = { width: 844, height: 390 };
const screens = { upright, lying, narrow: { width: 900, height: 640 }, laptop: { width: 1440, height: 900 }, desk: { width: 1920, height: 1080 } };
const leastContrast = 4.5;
const clear = [0, 0, 0.2];
const scene = ballScene(600);

let browser;
let gateway;
let page;
let problems;

before(async () => {
  browser = await launch();
  gateway = await new MockGateway(process.env.VIEWER_FOLDER, scene).start();
  gateway.tool.position = clear;
  ({ page, problems } = await openViewer(browser, gateway.url, { context: { viewport: upright, deviceScaleFactor: 0.5, hasTouch: true, isMobile: true } }));
});
after(async () => {
  await browser.close();
  await gateway.stop();
  assert.deepEqual(problems, []);
});

// To a size of the page, and until it is drawn in that.
async function resize(size) {
  await page.setViewportSize(size);
  await until(page, ({ width, height }) => {
    const canvas = document.getElementById('canvas');
    return window.innerWidth === width && canvas.clientHeight === height && Math.abs(canvas.width / canvas.height - canvas.clientWidth / height) < 0.02;
  }, size);
  await settle(page);
}

const boxes = (selectors) => page.evaluate((list) => list.map((selector) => {
  const { left, top, right, bottom } = document.querySelector(selector).getBoundingClientRect();
  return { left, top, right, bottom };
}), selectors);
const overlap = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;

describe('on a phone', () => {
  beforeEach(async () => {
    await page.evaluate(() => window.dispatchEvent(new Event('blur')));
    gateway.reset(clear, scene);
    await until(page, (z) => window.palpateViewer.tool()?.[2] === z && !window.palpateViewer.held, clear[2]);
  });

  for (const [name, viewport] of Object.entries({ upright, lying })) {
    test(`${name}: nothing covers another, and all of it is reached`, async () => {
      await resize(viewport);
      const parts = ['.identity', '.tools', '#stop', '#hint', '#sheet'];
      const found = await boxes(parts);
      found.forEach((a, i) => {
        assert.ok(a.left >= 0 && a.top >= 0 && a.right <= viewport.width + 1 && a.bottom <= viewport.height + 1, `${parts[i]} is on the page`);
        found.slice(i + 1).forEach((b, k) => assert.ok(!overlap(a, b), `${parts[i]} and ${parts[i + 1 + k]}`));
      });
      const stop = found[2];
      assert.ok(stop.right - stop.left >= 44 && stop.bottom - stop.top >= 44, 'a thumb finds the stop');
      await page.locator('#sheet').tap();
      const [view, panels] = await boxes(['#view', '#sections']);
      assert.ok(!overlap(view, panels), 'the panels leave the view alone');
      assert.ok(view.right - view.left > 0.4 * viewport.width && view.bottom - view.top > 0.4 * viewport.height, JSON.stringify(view));
      await page.locator('#sheet').tap();
      await settle(page);
    });
  }

  test('a tap brings the tool to the surface, and it is felt: one action by touch', async () => {
    await resize(upright);
    await page.touchscreen.tap(...await ask(page, (v) => v.project([0, 0, 0])));
    await until(page, () => Math.hypot(...(window.palpateViewer.force() ?? [0])) > 0.1);
    await page.locator('#hint').waitFor({ state: 'hidden' });
  });
});

describe('nothing covers another', () => {
  // What is seen of the page's parts, by selector.
  const seenParts = async () => {
    const parts = ['.identity', '.tools', '#stop', '#stopped', '#size', '#hint', '.legend', '.notices', '#sheet', '.panels:not(.closed) .sections'];
    const shown = await page.evaluate((list) => list.filter((selector) => document.querySelector(selector)?.checkVisibility()), parts);
    const found = await boxes(shown);
    return Object.fromEntries(shown.map((name, i) => [name, found[i]]).filter(([, box]) => box.bottom > box.top));
  };

  function check(parts, { width, height }) {
    const list = Object.entries(parts);
    for (const [name, box] of list) {
      assert.ok(box.left >= 0 && box.top >= 0 && box.right <= width + 1 && box.bottom <= height + 1, `${name} is on the page: ${JSON.stringify(box)}`);
    }
    list.forEach(([a, box], i) => list.slice(i + 1).forEach(([b, other]) =>
      assert.ok(!overlap(box, other), `${a} ${JSON.stringify(box)} and ${b} ${JSON.stringify(other)}`)));
  }

  before(async () => {
    gateway.reset(clear, scene);
    await page.evaluate(() => { document.getElementById('hint').hidden = false; });
  });
  after(async () => {
    await page.locator('#resume').dispatchEvent('click');
    await page.locator('#stopped').waitFor({ state: 'hidden' });
  });

  for (const [name, viewport] of Object.entries(screens)) {
    test(`${name}: with hints, without, and with a stop and a notice`, async () => {
      await resize(viewport);
      const hint = (shown) => page.evaluate((on) => { document.getElementById('hint').hidden = !on; }, shown);
      await hint(true);
      check(await seenParts(), viewport);
      await page.locator('#stop').dispatchEvent('click');
      await page.locator('#stopped').waitFor();
      for (const hints of [true, false]) {
        await hint(hints);
        await page.locator('#scene-file').setInputFiles({ name: 'garden.spz', mimeType: '', buffer: Buffer.from([0]) });
        await page.locator('.notice').waitFor();
        const parts = await seenParts();
        assert.ok('#stopped' in parts && '.notices' in parts && hints === ('#hint' in parts), Object.keys(parts).join());
        check(parts, viewport);
      }
    });
  }
});

// The contrast of every text that is seen with what is behind it, as {text, ratio}.
const contrasts = () => page.evaluate(() => {
  const context = Object.assign(document.createElement('canvas'), { width: 1, height: 1 }).getContext('2d', { willReadFrequently: true });
  const parse = (color) => { // whatever notation it is in
    context.clearRect(0, 0, 1, 1);
    context.fillStyle = color;
    context.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = context.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = ([r, g, b, a], below) => [r, g, b].map((c, k) => a * c + (1 - a) * below[k]);
  const linear = (c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4);
  const luminance = (rgb) => 0.2126 * linear(rgb[0]) + 0.7152 * linear(rgb[1]) + 0.0722 * linear(rgb[2]);
  const behind = (node) => {
    const layers = [];
    for (let n = node; n; n = n.parentElement) layers.unshift(parse(getComputedStyle(n).backgroundColor));
    return layers.reduce((below, layer) => over(layer, below), [255, 255, 255]);
  };
  const seen = [...document.querySelectorAll('body *')].filter((node) => node.checkVisibility() && !node.closest('svg')
    && [...node.childNodes].some((c) => c.nodeType === Node.TEXT_NODE && c.textContent.trim()));
  return seen.map((node) => {
    const below = behind(node);
    const text = over(parse(getComputedStyle(node).color), below);
    const [high, low] = [luminance(text), luminance(below)].sort((a, b) => b - a);
    return { text: node.textContent.trim().slice(0, 30), ratio: (high + 0.05) / (low + 0.05) };
  });
});

describe('for everyone', () => {
  before(async () => {
    await page.setViewportSize({ width: 900, height: 640 });
    gateway.reset(clear, scene);
    await page.evaluate(() => {
      document.getElementById('hint').hidden = false;
      for (const details of document.querySelectorAll('details')) details.open = true;
    });
    await page.getByRole('button', { name: 'Propose a setup' }).click();
    await page.getByText('the median Gaussian').waitFor();
  });

  for (const colorScheme of ['light', 'dark']) {
    for (const state of ['active', 'stopped']) {
      test(`the contrast of all text is at least ${leastContrast}, ${colorScheme}, ${state}`, async () => {
        await page.emulateMedia({ colorScheme, reducedMotion: 'reduce' });
        await page.locator(state === 'stopped' ? '#stop' : '#resume').dispatchEvent('click');
        await waitFor(() => (gateway.fault.level === 2) === (state === 'stopped'), state);
        await page.waitForFunction((on) => document.body.classList.contains('stopped-force') === on, state === 'stopped');
        const all = await contrasts();
        assert.ok(all.length > 60, `${all.length} texts`);
        assert.deepEqual(all.filter(({ ratio }) => ratio < leastContrast), []);
      });
    }
  }

  test('nothing moves for those who want no motion', async () => {
    await page.emulateMedia({ reducedMotion: 'reduce' });
    assert.deepEqual(await page.evaluate(() => [...document.querySelectorAll('body *')]
      .filter((n) => parseFloat(getComputedStyle(n).transitionDuration) > 0 || getComputedStyle(n).animationName !== 'none').map((n) => n.id || n.className)), []);
  });

  test('every control has a name and is reached by the Tab key', async () => {
    const kinds = 'button, input, select, summary, a[href], canvas[tabindex]';
    const controls = await page.evaluate((selector) => [...document.querySelectorAll(selector)]
      .filter((n) => n.checkVisibility() && !n.disabled && !n.closest('[inert]'))
      .map((n, i) => {
        n.dataset.order = i;
        return { i, name: n.ariaLabel || n.labels?.[0]?.textContent || n.textContent.trim() || n.title, what: n.outerHTML.slice(0, 80) };
      }), kinds);
    assert.ok(controls.length > 40, `${controls.length} controls`);
    assert.deepEqual(controls.filter(({ name }) => !name), []);
    await page.evaluate(() => document.activeElement?.blur());
    const reached = new Set();
    for (let k = 0; k < controls.length + 20; k += 1) {
      await page.keyboard.press('Tab');
      reached.add(Number(await page.evaluate(() => document.activeElement.dataset.order ?? -1)));
    }
    const there = await page.evaluate(() => [...document.querySelectorAll('[data-order]')].map((n) => Number(n.dataset.order))); // notices go by themselves
    assert.ok(there.length > 40, `${there.length} controls`);
    assert.deepEqual(controls.filter(({ i }) => there.includes(i) && !reached.has(i)), []);
  });
});
