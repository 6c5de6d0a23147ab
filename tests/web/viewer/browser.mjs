// The viewer page in Chromium with software rendering, and what tests do there.

import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import path from 'node:path';

export { launch } from './chromium.mjs';

const patience = Number(process.env.PATIENCE ?? 60000); // software rendering on a small machine is slow. Unit: [ms].

const expected = /WebSocket connection to|ERR_CONNECTION_REFUSED|GPU stall|status of (422|503)/; // a server that is gone, or not ready, is part of some tests

/// Opens the viewer that `url` serves. `problems` collects console errors, page errors and requests to elsewhere.
export async function openViewer(browser, url, { context = {}, script, patience: wait = patience } = {}) {
  // A quarter of the pixels: drawing them in software would be most of the time.
  const page = await browser.newPage({ viewport: { width: 900, height: 640 }, deviceScaleFactor: 0.5, ...context });
  page.setDefaultTimeout(wait);
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

/// Waits until `condition`, which looks at what the test itself has, is true.
export async function waitFor(condition, what) {
  for (const end = Date.now() + patience; Date.now() < end;) {
    if (condition()) return;
    await new Promise((done) => { setTimeout(done, 5); });
  }
  throw new Error(`did not come: ${what}`);
}

/// Waits until `look` is true of window.palpateViewer, and is what it then is. Who asks afterwards may find something else.
export const until = async (page, look, argument) => (await page.waitForFunction(look, argument)).jsonValue();

/// What is seen of the page or of a part of it, {x, y, width, height}: {width, data}, r, g, b, a, r, ..., 0 to 255.
export async function picture(page, clip) {
  const shot = await page.screenshot(clip ? { clip } : {});
  const { width, text } = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    const texts = Array.from({ length: Math.ceil(data.length / 8192) }, (_, i) => String.fromCharCode(...data.subarray(8192 * i, 8192 * (i + 1))));
    return { width: image.width, text: btoa(texts.join('')) }; // numbers one by one would take seconds
  }, shot.toString('base64'));
  return { width, data: [...Buffer.from(text, 'base64')] };
}

/// The colours of the page at some points, as [r, g, b] each, 0 to 255: of one picture, since taking one takes long.
export async function colorsAt(page, points) {
  const { width, data } = await picture(page);
  const scale = width / page.viewportSize().width;
  return points.map(([x, y]) => {
    const at = 4 * (Math.floor(y * scale) * width + Math.floor(x * scale));
    return data.slice(at, at + 3);
  });
}

/// The colours where points of the world are seen.
export async function colorsOf(page, points) {
  return colorsAt(page, await ask(page, (v, list) => list.map((p) => v.project(p)), points));
}

/// A headset for addInitScript: window.headset is iwer's XRDevice, installed before the page runs.
export async function headsetScript() {
  const entry = createRequire(import.meta.url).resolve('iwer');
  const library = await readFile(path.join(path.dirname(entry), '..', 'build', 'iwer.min.js'), 'utf8');
  return `${library}
    window.headset = new IWER.XRDevice(IWER.metaQuest3);
    window.headset.installRuntime({ forceInstall: true });`;
}
