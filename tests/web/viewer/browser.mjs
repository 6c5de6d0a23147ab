// The viewer page in Chromium with software rendering, and what tests do there.

import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import path from 'node:path';
import { chromium } from 'playwright-core';

const browserPath = process.env.CHROMIUM ?? '/usr/bin/chromium';
const quiet = ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync'];
const noGl = ['--disable-gpu', '--disable-3d-apis'];
const softwareGl = ['--enable-unsafe-swiftshader', '--use-gl=angle', '--use-angle=swiftshader'];
const patience = 60000; // software rendering on a small machine is slow. Unit: [ms].

export const launch = ({ webgl = true } = {}) =>
  chromium.launch({ executablePath: browserPath, args: [...quiet, ...(webgl ? softwareGl : noGl)] });

const expected = /WebSocket connection to|ERR_CONNECTION_REFUSED|GPU stall/; // a server that is gone is part of some tests

/// Opens the viewer that `url` serves. `problems` collects console errors, page errors and requests to elsewhere.
export async function openViewer(browser, url, { context = {}, script } = {}) {
  // A quarter of the pixels: drawing them in software would be most of the time.
  const page = await browser.newPage({ viewport: { width: 900, height: 640 }, deviceScaleFactor: 0.5, ...context });
  page.setDefaultTimeout(patience);
  const problems = [];
  page.on('console', (m) => { if (m.type() === 'error' && !expected.test(m.text())) problems.push(`console: ${m.text()}`); });
  page.on('pageerror', (error) => problems.push(`page: ${error.message}`));
  page.on('request', (request) => {
    const to = new URL(request.url());
    if (to.host !== new URL(url).host && !/^(blob|data):$/.test(to.protocol)) problems.push(`request: ${request.url()}`);
  });
  if (script) await page.addInitScript(script);
  await page.goto(url);
  await page.waitForFunction(() => window.palpateViewer?.ready);
  await settle(page);
  return { page, problems };
}

/// Waits until `frames` more frames have been drawn, or there was nothing to draw for as many.
export async function settle(page, frames = 3) {
  await page.evaluate((count) => new Promise((done) => {
    const { frames: before } = window.palpateViewer;
    let looks = 0;
    const look = () => {
      const { frames, idle } = window.palpateViewer;
      if (frames >= before + count || (++looks > count && idle >= count)) done();
      else requestAnimationFrame(look);
    };
    look();
  }), frames);
}

/// What `look` says of window.palpateViewer.
export const ask = (page, look, argument) => page.evaluate(
  ([source, value]) => new Function('viewer', 'value', `return (${source})(viewer, value)`)(window.palpateViewer, value),
  [look.toString(), argument]);

/// Waits until `look` is true of window.palpateViewer.
export const until = (page, look, argument) => page.waitForFunction(look, argument);

/// What is seen of a part of the page, {x, y, width, height}, as r, g, b, a, r, ..., 0 to 255.
export async function picture(page, clip) {
  const shot = await page.screenshot({ clip });
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    return [...context.getImageData(0, 0, image.width, image.height).data];
  }, shot.toString('base64'));
}

/// The colour of a pixel of the page as [r, g, b], 0 to 255.
export async function pixel(page, [x, y]) {
  return (await picture(page, { x: Math.round(x), y: Math.round(y), width: 1, height: 1 })).slice(0, 3);
}

/// A headset for addInitScript: window.headset is iwer's XRDevice, installed before the page runs.
export async function headsetScript() {
  const entry = createRequire(import.meta.url).resolve('iwer');
  const library = await readFile(path.join(path.dirname(entry), '..', 'build', 'iwer.min.js'), 'utf8');
  return `${library}
    window.headset = new IWER.XRDevice(IWER.metaQuest3);
    window.headset.installRuntime({ forceInstall: true });`;
}
