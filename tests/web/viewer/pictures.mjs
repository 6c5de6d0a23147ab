// Takes the pictures of the viewer that the documents show: a hand presses on the pear of the built-in scene, at a desk, on a phone
// and in a headset. usage: node pictures.mjs OUT_FOLDER, with PALPATE_BINARY

import path from 'node:path';

import { ask, headsetScript, launch, openViewer, settle } from './browser.mjs';
import { Program } from './program.mjs';

const out = process.argv[2];
const patience = 120000; // Unit: [ms].
const pear = [0.145, -0.035, 0.0365]; // its middle. Unit: [m].
const outwards = [0.85, -0.3, 0.42]; // from there, so that the force is seen from the side
const at = (distance) => pear.map((c, k) => (c + distance * outwards[k]).toFixed(4)).join();
// It is lifted every 18 s: where drawing has held up the loop, the force comes back.
const trajectory = `t,x,y,z\n0,${at(0.12)}\n2,${at(0.12)}\n3,${at(0.036)}\n10,${at(0.036)}\n`;

const touches = (page) => ask(page, (v) => v.drawnContacts() > 5 && Math.hypot(...v.force() ?? [0]) > 0.5);

/// A picture in which the tool touches, before it was taken and after.
async function take(page, name) {
  for (const end = Date.now() + patience; Date.now() < end;) {
    if (await touches(page)) {
      await page.screenshot({ path: path.join(out, `viewer-${name}.png`) });
      if (await touches(page)) return;
    }
    await settle(page, 1);
  }
  throw new Error(`nothing was touched: ${name}`);
}

async function atDesk(browser, url) {
  const { page } = await openViewer(browser, url, { patience, context: { viewport: { width: 1280, height: 800 }, deviceScaleFactor: 1 } });
  await page.getByRole('button', { name: 'Find tool' }).click();
  await settle(page, 8);
  await take(page, 'contact');
  await page.close();
}

async function onPhone(browser, url) {
  const context = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 1, hasTouch: true, isMobile: true };
  const { page } = await openViewer(browser, url, { patience, context });
  await page.getByRole('button', { name: 'Find tool' }).click();
  await settle(page, 8);
  await take(page, 'phone');
  await page.close();
}

async function inHeadset(browser, url) {
  const { page } = await openViewer(browser, url, { patience, script: await headsetScript(), context: { viewport: { width: 1440, height: 720 }, deviceScaleFactor: 1 } });
  await page.evaluate(() => {
    const { headset } = window;
    headset.stereoEnabled = true;
    headset.controllers.left.position.set(-0.14, 1.15, -0.45);
    headset.controllers.right.position.set(0.2, 1.15, -0.35);
    headset.quaternion.set(-Math.sin(0.22), 0, 0, Math.cos(0.22));
  });
  await page.getByRole('button', { name: 'VR', exact: true }).click();
  await page.waitForFunction(() => window.palpateViewer.presenting);
  await settle(page, 4);
  await take(page, 'vr');
  await page.close();
}

const program = await Program.create();
await program.startWith(trajectory);
const browser = await launch();
try {
  await atDesk(browser, program.url);
  await onPhone(browser, program.url);
  await inHeadset(browser, program.url);
} finally {
  await browser.close();
  await program.stop();
  await program.remove();
}
