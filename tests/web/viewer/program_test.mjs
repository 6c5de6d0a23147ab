// The viewer page against the program itself. Needs PALPATE_BINARY; the scene is a ball at the origin.

import assert from 'node:assert/strict';
import { after, afterEach, before, beforeEach, describe, test } from 'node:test';

import { ask, headsetScript, launch, openViewer, pixel, settle, until } from './browser.mjs';
import { Program } from './program.mjs';

const radius = 0.15; // of the ball of make-scene. Unit: [m].
const above = [0, 0, 0.3]; // where the tool waits
const view = [0.62, -0.78, 0.5].map((c) => c / Math.hypot(0.62, 0.78, 0.5)); // from the scene to the camera at first
const right = [0.78, 0.62, 0].map((c) => c / Math.hypot(0.78, 0.62));

let browser;
let program;
let page;
let problems;

const scaled = (v, by) => v.map((c) => c * by);
const dot = (a, b) => a.reduce((sum, c, k) => sum + c * b[k], 0);
const distance = (a, b) => Math.hypot(...a.map((c, k) => c - b[k]));
const project = (point) => ask(page, (v, p) => v.project(p), point);

async function open(options) {
  ({ page, problems } = await openViewer(browser, program.url, options));
  await until(page, (p) => Math.hypot(...window.palpateViewer.tool().map((c, k) => c - p[k])) < 0.01, above);
}

before(async () => {
  browser = await launch();
  program = await Program.create();
});
after(async () => {
  await browser.close();
  await program.remove();
});

describe('at a desk', () => {
  beforeEach(async () => {
    await program.start(above);
    await open();
  });
  afterEach(async () => {
    await page.close();
    await program.stop();
    assert.deepEqual(problems, []);
  });

  // The point of the plane of the screen through the tool that is nearest to the middle of the ball: 0.13 m from it.
  const inside = scaled(view, dot(above, view));

  async function drag(to) {
    const [from, target] = [await project(await ask(page, (v) => v.tool())), await project(to)];
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.mouse.move(...target, { steps: 10 });
    return target;
  }

  test('the scene is where the program says', async () => {
    const colorAt = async (share) => pixel(page, await project(scaled(right, share * radius)));
    const background = await pixel(page, await project(scaled(right, 1.25 * radius)));
    assert.ok(distance(await colorAt(0.9), background) > 30);
    assert.ok(distance(await colorAt(-0.9), background) > 30);
    assert.ok(distance(await colorAt(-1.25), background) < 5);
    assert.ok(await ask(page, (v) => v.kept()) > 600);
  });

  test('the tool follows a drag through the air', async () => {
    const target = await drag([above[0] + 0.05 * right[0], above[1] + 0.05 * right[1], above[2]]);
    await until(page, ([x, y]) => {
      const at = window.palpateViewer.project(window.palpateViewer.tool());
      return Math.hypot(at[0] - x, at[1] - y) < 6;
    }, target);
    await page.mouse.up();
  });

  test('contacts light up where the tool touches, the arrow points outward, and both go out', async () => {
    assert.equal(await ask(page, (v) => v.drawnContacts()), 0);
    await drag(inside);
    await until(page, () => window.palpateViewer.drawnContacts() > 0 && window.palpateViewer.arrow() !== null);
    const seen = await ask(page, (v) => ({ tool: v.tool(), arrow: v.arrow(), force: v.force() }));
    const outward = scaled(seen.tool, 1 / Math.hypot(...seen.tool));
    assert.ok(dot(seen.arrow, outward) > 0.7, `${seen.arrow} at ${seen.tool}`);
    assert.ok(dot(seen.force, outward) > 0);
    for (const { center } of await ask(page, (v) => v.contacts())) {
      assert.ok(distance(center, seen.tool) < 0.06, `a contact at ${center}, the tool at ${seen.tool}`);
    }
    const [x, y] = await project(scaled(above, 1.1));
    await page.mouse.move(x, y, { steps: 10 });
    await until(page, () => window.palpateViewer.drawnContacts() === 0 && window.palpateViewer.arrow() === null);
    await page.mouse.up();
  });

  test('a stiffness that is set in the panel changes the force', async () => {
    const set = (value) => page.locator('[data-field=stiffness]').first().evaluate((node, v) => {
      node.value = v;
      node.dispatchEvent(new Event('change'));
    }, value);
    const settled = () => page.waitForFunction(() => {
      const [force, past] = [window.palpateViewer.force(), window.pastForce];
      window.pastForce = force;
      return force && past && Math.hypot(...force) > 0.2 && Math.hypot(...force.map((c, k) => c - past[k])) < 0.01;
    }, null, { polling: 400, timeout: 20000 });
    // The force while the tool is pressed in. Where the machine stands still for a moment there is none until the tool
    // is free again: then once more.
    const pressed = async (stiffness) => {
      await set(String(stiffness));
      await until(page, (value) => window.palpateViewer.parameters().stiffness === value, stiffness);
      for (let k = 0; ; k += 1) {
        await drag(inside);
        const felt = await settled().then(() => true, () => false);
        const force = felt ? await ask(page, (v) => Math.hypot(...(v.force() ?? [0]))) : 0;
        await page.mouse.up();
        await until(page, (p) => Math.hypot(...window.palpateViewer.tool().map((c, i) => c - p[i])) < 0.01, above);
        if (force > 0.2) return force;
        assert.ok(k < 3, 'no force came');
      }
    };
    const soft = await pressed(100);
    const firm = await pressed(1000);
    assert.ok(firm > 1.3 * soft, `${soft} and ${firm}`);
  });

  test('what is set in the panels is what the program has', async () => {
    const field = (name) => page.locator(`[data-field=${name}]`).first();
    const enter = async (name, value) => {
      await field(name).fill(value);
      await field(name).press('Enter');
    };
    await enter('opacity_min', '0.25');
    await enter('sigma', '1.5');
    await until(page, () => {
      const { filter } = window.palpateViewer.parameters();
      return filter.opacity_min === 0.25 && filter.sigma === 1.5;
    });
    await page.evaluate(() => document.querySelectorAll('details').forEach((d) => { d.open = true; }));
    await enter('translation-0', '0.1');
    await page.getByRole('button', { name: 'Mirrored' }).click();
    await until(page, () => {
      const { matrix, mirrored } = window.palpateViewer.parameters().registration;
      return mirrored && matrix[0] === -1 && matrix[12] === 0.1;
    });
  });

  test('it comes back after a restart', async () => {
    await program.stop();
    await page.waitForFunction(() => document.getElementById('state').textContent === 'disconnected');
    await program.start(above);
    await until(page, () => window.palpateViewer.connected && window.palpateViewer.force() !== null);
  });

  test('an emergency stop takes the force away until it is resumed', async () => {
    await page.keyboard.press('Escape');
    await page.waitForFunction(() => /emergency-stop/.test(document.getElementById('state').textContent));
    await page.getByRole('button', { name: 'Resume' }).click();
    await page.waitForFunction(() => !/emergency-stop/.test(document.getElementById('state').textContent));
  });
});

describe('contacts and what can be felt are drawn where and as large as the program has them', () => {
  const scenes = {
    'as is': { options: [], at: [0, 0, 0.165] },
    'scaled, turned and moved': {
      options: ['--scale', '2', '--rotate', '0.8,0.6,0,0', '--translate', '0.1,-0.2,0.3'],
      at: [0.1, -0.2, 0.3 + 2 * radius + 0.015],
    },
    'mirrored, turned and moved': {
      options: ['--mirror', '--rotate', '0.8,0,0.6,0', '--translate', '0.1,-0.2,0.3'],
      at: [0.1, -0.2, 0.3 + radius + 0.015],
    },
    'cropped, and at the visible level': {
      options: ['--iso', '0.7', '--crop-sphere', '0,0,0.3,0.2', '--max-scale', '0.03', '--scale', '2'],
      at: [0, 0, 2 * radius + 0.015],
    },
  };
  for (const [name, { options, at }] of Object.entries(scenes)) {
    test(name, async () => {
      await program.start(at, [...options, '--model', 'density']);
      ({ page, problems } = await openViewer(browser, program.url));
      await until(page, () => window.palpateViewer.drawnContacts() > 0);
      const tool = await ask(page, (v) => v.tool());
      const found = new Map((await program.query(tool, options)).contacts.map((c) => [c.id, c.center]));
      assert.equal(await ask(page, (v) => v.kept()), await program.kept(options));
      assert.equal(await page.getByText('opacity of 0.7').count(), options.includes('--iso') ? 1 : 0);
      let compared = 0;
      for (const { id, center, scale } of await ask(page, (v) => v.contacts())) {
        const drawn = await ask(page, (v, i) => v.centreOfDrawnContact(i), id);
        if (!drawn || !found.has(id)) continue; // touched at one of the two instants only
        assert.ok(distance(drawn, center) < 1e-4);
        assert.ok(distance(drawn, found.get(id)) < 1e-4, `${id}: ${drawn}, not ${found.get(id)}`);
        const felt = await ask(page, (v, i) => v.feltScale(i), id);
        felt.forEach((size, k) => assert.ok(Math.abs(size / scale[k] - 1) < 1e-3, `${id}: ${felt}, not ${scale}`));
        ++compared;
      }
      assert.ok(compared > 0);
      await page.close();
      await program.stop();
      assert.deepEqual(problems, []);
    });
  }
});

describe('in a headset', () => {
  // WebXR's x, y, z of a point of the world, as a small scene is put first: its middle is half a metre ahead.
  const put = ([x, y, z]) => page.evaluate((p) => window.headset.controllers.right.position.set(...p), [x, 1.1 + z, -(0.5 + y)]);
  const trigger = (value) => page.evaluate((v) => window.headset.controllers.right.updateButtonValue('trigger', v), value);

  test('the controller feels the surface, the more the deeper, and nothing after it has left', async () => {
    await program.start(above);
    await open({ script: await headsetScript(), context: { viewport: { width: 480, height: 360 } } });
    await page.getByRole('button', { name: 'VR', exact: true }).click();
    await until(page, () => window.palpateViewer.presenting);
    await settle(page); // until then the session has no controllers
    await put(above);
    await trigger(1);
    await until(page, () => window.palpateViewer.held);
    const meanAt = async (height) => {
      const before = (await ask(page, (v) => v.pulses)).length;
      await put([0, 0, height]);
      await page.waitForFunction((since) => {
        const pulses = window.palpateViewer.pulses.slice(since).slice(-6); // of this height, and steady
        const forces = pulses.map((p) => p.force);
        return window.palpateViewer.pulses.length > since + 10 && pulses.every((p) => p.kind !== 'click')
          && Math.max(...forces) - Math.min(...forces) < 0.01;
      }, before);
      const last = (await ask(page, (v) => v.pulses)).filter((p) => p.kind === 'hum').slice(-4);
      return { force: last.at(-1).force, intensity: last.reduce((sum, p) => sum + p.intensity, 0) / last.length };
    };
    const [light, firm] = [await meanAt(0.18), await meanAt(0.14)];
    assert.ok(firm.force > 1.2 * light.force && firm.intensity > light.intensity, JSON.stringify([light, firm]));
    assert.equal((await ask(page, (v) => v.pulses))[0].kind, 'click');
    assert.ok(await ask(page, (v) => v.drawnContacts()) > 0);
    await put(above);
    await until(page, () => window.palpateViewer.drawnContacts() === 0 && Math.hypot(...(window.palpateViewer.force() ?? [1])) < 0.05);
    const count = (await ask(page, (v) => v.pulses)).length;
    await settle(page, 5);
    assert.equal((await ask(page, (v) => v.pulses)).length, count);
    await trigger(0);
    assert.deepEqual(problems, []);
  });

  afterEach(async () => {
    await page.close();
    await program.stop();
  });
});
