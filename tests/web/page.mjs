// Fills a built report page, opens it in Chromium from file:// and watches what it does.

import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import os from 'node:os';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

export { launch } from './chromium.mjs';

const patience = 120000; // software rendering on a small machine is slow. Unit: [ms].

const escapeHtml = (text) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;');

/// What `palpate report` does with the template.
export function fillTemplate(template, run) {
  return template
    .replace('<!--PALPATE_TITLE-->', () => escapeHtml(run.title))
    .replace('<!--PALPATE_RUN_JSON-->', () => JSON.stringify(run).replaceAll('<', '\\u003c'));
}

export async function readTemplate() {
  if (!process.env.REPORT_PAGE) throw new Error('REPORT_PAGE must name the built report page');
  return readFile(process.env.REPORT_PAGE, 'utf8');
}

/// Opens `run` in a page of its own. `problems` collects console errors, page errors, dialogs and
/// every request other than the file; `close` takes the page and the file away.
export async function openReport(browser, run, context = {}) {
  const folder = await mkdtemp(path.join(os.tmpdir(), 'palpate-report-'));
  const file = path.join(folder, 'report.html');
  await writeFile(file, fillTemplate(await readTemplate(), run));
  const url = pathToFileURL(file).href;
  const problems = [];
  const page = await browser.newPage({ viewport: { width: 1440, height: 1000 }, ...context });
  page.setDefaultTimeout(patience);
  page.on('console', (m) => { if (m.type() === 'error') problems.push(`console: ${m.text()}`); });
  page.on('pageerror', (error) => problems.push(`page: ${error.message}`));
  page.on('dialog', (dialog) => { problems.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  await page.route('**/*', (route) => {
    if (route.request().url() === url) return route.continue();
    problems.push(`request: ${route.request().url()}`);
    return route.abort();
  });
  await page.goto(url);
  await page.waitForFunction(() => window.palpateReport, null);
  await settle(page);
  const close = async () => {
    await page.close();
    await rm(folder, { recursive: true, force: true });
  };
  return { page, problems, close };
}

/// Waits until what was asked for has been drawn.
export const settle = (page) =>
  page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

/// The pixels of a canvas inside `selector`, over the card that shows through where it is clear, as
/// {width, height, data: r, g, b, a, r, ...}.
/// WebGL canvases are kept after drawing, so they can be copied like any other. The bytes travel as
/// base64, which is far quicker than a list of numbers.
export async function canvasPixels(page, selector) {
  const { width, height, bytes } = await page.evaluate((css) => {
    const source = document.querySelector(`${css} canvas`);
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [source.width, source.height];
    const context = copy.getContext('2d', { willReadFrequently: true });
    context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--card');
    context.fillRect(0, 0, copy.width, copy.height);
    context.drawImage(source, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    const chunks = [];
    for (let i = 0; i < data.length; i += 8192) chunks.push(String.fromCharCode(...data.subarray(i, i + 8192)));
    return { width: copy.width, height: copy.height, bytes: btoa(chunks.join('')) };
  }, selector);
  return { width, height, data: Buffer.from(bytes, 'base64') };
}
