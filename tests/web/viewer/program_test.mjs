// The viewer page against the program itself. Needs PALPATE_BINARY; the scene is a ball at the origin. One page sees one
// program after another: it connects again by itself.

import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';

import { ask, colorsOf, headsetScript, launch, openViewer, settle, until } from './browser.mjs';
import { asciiOf, ballScene, mipOpacity, mipScene, strayScene } from './mock_scene.mjs';
import { countHeldUp, Program } from './program.mjs';

const radius = 0.15; // of the ball of make-scene. Unit: [m].
const above = [0, 0, 0.3]; // where the tool waits

let browser;
let program;
let page;
let problems;

const scaled = (v, by) => v.map((c) => c * by);
const dot = (a, b) => a.reduce((sum, c, k) => sum + c * b[k], 0);
const distance = (a, b) => Math.hypot(...a.map((c, k) => c - b[k]));
const project = (point) => ask(page, (v, p) => v.project(p), point);
const axes = () => ask(page, (v) => v.axes());
const isFelt = () => Math.hypot(...(window.palpateViewer.force() ?? [0])) > 0.1;

// With the tool at `at`, and on the page.
async function start(at, options, scene) {
  await program.start(at, options, scene);
  await until(page, (p) => {
    const viewer = window.palpateViewer;
    return viewer.ready && Math.hypot(...viewer.tool().map((c, k) => c - p[k])) < 0.01;
  }, at);
}

async function restart(at, options, scene) {
  await program.stop();
  await page.waitForFunction(() => document.getElementById('state').textContent === 'disconnected');
  await start(at, options, scene);
}

// The demo takes the tool back to where it waits.
async function goBack() {
  await page.getByRole('button', { name: 'Start demo' }).click();
  await until(page, (p) => Math.hypot(...window.palpateViewer.tool().map((c, k) => c - p[k])) < 0.002 && window.palpateViewer.parameters().demo, above);
}

let heldUpBefore = 0; // the attempt

// Waits until `look` is true of the page, as long as the program is not held up. One function: the page's own rules forbid to make
// functions of text there.
const untilFelt = async (look, argument, options = {}) => {
  const undisturbedLook = new Function('[before, value]', `
    if ((${countHeldUp})() > before) return { heldUp: true }; // an error would be one of the page
    const seen = (${look})(value);
    return seen && { seen };`);
  const { heldUp, seen } = await (await page.waitForFunction(undisturbedLook, [heldUpBefore, argument], options)).jsonValue();
  if (heldUp) throw new Error('the program was held up');
  return seen;
};

// Takes the tool to where an attempt begins.
async function lift(begin) {
  await page.mouse.up();
  const resume = page.locator('#resume');
  if (await resume.isVisible()) await resume.click();
  await begin();
}

// `attempt`, once more from `begin` on where the program was held up meanwhile.
async function undisturbed(attempt, begin = goBack) {
  const isActive = () => document.getElementById('state').textContent === 'active';
  for (let tries = 1; ; ++tries) {
    heldUpBefore = await page.evaluate(countHeldUp);
    try {
      // Held up since the last test, or again while it waits for the tool to be lifted, it says nothing more, and a tool that is
      // pressed then waits for ever.
      if (!await page.evaluate(isActive)) await lift(begin);
      await until(page, isActive);
      await attempt();
      return;
    } catch (error) {
      if (tries === 5 || await page.evaluate(countHeldUp) === heldUpBefore) throw error;
      await lift(begin);
    }
  }
}

before(async () => {
  browser = await launch();
  program = await Program.create();
  await program.start(above);
  ({ page, problems } = await openViewer(browser, program.url, { script: await headsetScript() }));
  await until(page, (p) => Math.hypot(...window.palpateViewer.tool().map((c, k) => c - p[k])) < 0.01, above);
});
after(async () => {
  await browser.close();
  await program.stop();
  await program.remove();
  assert.deepEqual(problems, []);
});

describe('at a desk', () => {
  // A page that has just been held up does not know where the tool is, and a press then turns the view: it is caught again.
  async function drag(to) {
    for (let tries = 1; ; ++tries) {
      await page.mouse.move(...await project(await ask(page, (v) => v.tool())));
      await page.mouse.down();
      if (await page.locator('canvas.holding').count() > 0) break;
      await page.mouse.up();
      assert.ok(tries < 5, 'the tool is not caught where it is seen');
      await settle(page, 10);
    }
    const target = await project(to);
    await page.mouse.move(...target, { steps: 10 });
    return target;
  }

  // The point of the plane of the screen through the tool that is nearest to the middle of the ball: 0.13 m from it.
  const inside = async () => {
    const toCamera = scaled((await axes()).forward, -1);
    return scaled(toCamera, dot(above, toCamera));
  };

  test('the scene is where the program says', async () => {
    const { right } = await axes();
    const [background, ...colors] = await colorsOf(page, [1.25, 0.9, -0.9, -1.25].map((share) => scaled(right, share * radius)));
    assert.ok(distance(colors[0], background) > 30);
    assert.ok(distance(colors[1], background) > 30);
    assert.ok(distance(colors[2], background) < 5);
    assert.ok(await ask(page, (v) => v.kept()) > 600);
  });

  test('a click brings the tool to the surface, where it is felt and stays', () => undisturbed(async () => {
    const { forward, right } = await axes();
    const point = [0, 1, 2].map((k) => radius * (-0.9 * forward[k] - Math.sqrt(1 - 0.81) * right[k]));
    await page.mouse.click(...await project(point));
    await until(page, () => !window.palpateViewer.approaching && window.palpateViewer.parameters().demo === false);
    await untilFelt(isFelt);
    await page.waitForFunction(() => /stays where it is/.test(document.getElementById('holder').textContent));
    // A program that is held up says late where it has brought the tool.
    const left = await untilFelt(() => {
      const [tool, past] = [window.palpateViewer.tool(), window.pastTool];
      window.pastTool = tool;
      return past && Math.hypot(...tool.map((c, k) => c - past[k])) < 1e-4 && tool;
    }, null, { polling: 500 });
    assert.ok(distance(left, point) < 0.06, `${distance(left, point)} m from where it was clicked`);
    await settle(page, 10);
    assert.ok(distance(await ask(page, (v) => v.tool()), left) < 1e-3);
    await goBack();
  }));

  test('one key brings it to the middle of the view, where it is felt', () => undisturbed(async () => {
    await page.keyboard.press('c');
    await untilFelt(isFelt);
    await goBack();
  }));

  test('the tool follows a drag through the air', async () => {
    const { right } = await axes();
    const target = await drag([above[0] + 0.05 * right[0], above[1] + 0.05 * right[1], above[2]]);
    await until(page, ([x, y]) => {
      const at = window.palpateViewer.project(window.palpateViewer.tool());
      return Math.hypot(at[0] - x, at[1] - y) < 6;
    }, target);
    await page.mouse.up();
    await goBack();
  });

  test('contacts light up where the tool touches, the arrow points outward, and both go out', () => undisturbed(async () => {
    assert.equal(await ask(page, (v) => v.drawnContacts()), 0);
    await drag(await inside());
    const seen = await untilFelt(() => { // at one instant: on a busy machine they may go out in between
      const v = window.palpateViewer;
      return v.drawnContacts() > 0 && v.arrow() !== null && v.force() !== null
        && { tool: v.tool(), arrow: v.arrow(), force: v.force(), contacts: v.contacts() };
    });
    const outward = scaled(seen.tool, 1 / Math.hypot(...seen.tool));
    assert.ok(dot(seen.arrow, outward) > 0.7, `${seen.arrow} at ${seen.tool}`);
    assert.ok(dot(seen.force, outward) > 0);
    for (const { center } of seen.contacts) {
      assert.ok(distance(center, seen.tool) < 0.06, `a contact at ${center}, the tool at ${seen.tool}`);
    }
    const [x, y] = await project(scaled(above, 1.1));
    await page.mouse.move(x, y, { steps: 10 });
    await until(page, () => window.palpateViewer.drawnContacts() === 0 && window.palpateViewer.arrow() === null);
    await page.mouse.up();
    await goBack();
  }));

  test('a stiffness that is set in the panel changes the force', () => undisturbed(async () => {
    const settled = (least) => untilFelt((above) => {
      const [force, past] = [window.palpateViewer.force(), window.pastForce];
      window.pastForce = force;
      return force && past && Math.hypot(...force) > above && Math.hypot(...force.map((c, k) => c - past[k])) < 0.01 && Math.hypot(...force);
    }, least, { polling: 100 });
    const set = async (stiffness) => {
      await page.locator('[data-field=stiffness]').first().fill(String(stiffness));
      await page.keyboard.press('Enter');
      await until(page, (value) => window.palpateViewer.parameters().stiffness === value, stiffness);
    };
    await set(100);
    await drag(await inside());
    const soft = await settled(0.2);
    await set(1000);
    await settled(1.3 * soft); // the force changes after the parameter
    await page.mouse.up();
    await goBack();
  }));

  test('an emergency stop takes the force away until it is resumed, and the terminal’s line is on the page', async () => {
    await page.keyboard.press('Escape');
    await page.waitForFunction(() => /emergency-stop/.test(document.getElementById('state').textContent));
    await page.evaluate(() => document.querySelectorAll('details').forEach((d) => { d.open = true; }));
    await page.locator('#messages li', { hasText: 'no force: emergency-stop' }).waitFor();
    await page.locator('#messages li', { hasText: 'omega (simulated)' }).waitFor();
    await page.locator('#resume').click();
    await page.waitForFunction(() => !/emergency-stop/.test(document.getElementById('state').textContent));
  });

  test('what is set in the panels is what the program has', async () => {
    const enter = async (name, value) => {
      const field = page.locator(`[data-field=${name}]`).first();
      await field.fill(value);
      await field.press('Enter');
    };
    await enter('opacity_min', '0.25');
    await enter('sigma', '1.5');
    await until(page, () => {
      const { filter } = window.palpateViewer.parameters();
      return filter.opacity_min === 0.25 && filter.sigma === 1.5;
    });
    await enter('translation-0', '0.1');
    await page.getByRole('button', { name: 'Mirrored' }).click();
    await until(page, () => {
      const { matrix, mirrored } = window.palpateViewer.parameters().registration;
      return mirrored && matrix[0] === -1 && matrix[12] === 0.1;
    });
  });
});

describe('a scene that the viewer cannot read as it is', () => {
  test('is drawn all the same', async () => {
    const ball = ballScene(600);
    await restart(above, [], await program.write('ascii.ply', asciiOf(ball)));
    await until(page, (n) => window.palpateViewer.kept() === n, ball.gaussians.filter(({ opacity }) => opacity > 0.1).length);
    await settle(page, 8);
    const { right } = await axes();
    const [orange, blue] = await colorsOf(page, [0.09, -0.09].map((c) => scaled(right, c)));
    assert.ok(orange[0] > orange[2] + 60 && blue[2] > blue[0] + 60, `${orange}, ${blue}`);
    assert.equal(await page.locator('.notice').count(), 0);
  });

  test('or draws wrongly is drawn as it is felt', async () => {
    await restart(above, [], await program.write('mip.ply', mipScene().ply));
    await until(page, () => window.palpateViewer.kept() === 1);
    await settle(page, 8);
    const opacity = await ask(page, (v) => v.seenOpacity(v.project([0, 0, 0])));
    assert.ok(Math.abs(opacity - mipOpacity) < 0.03, `${opacity}, not ${mipOpacity}`);
  });
});

describe('a setup', () => {
  const current = () => ask(page, (v) => v.parameters());

  test('is proposed, applied whole, where the scene has been put, and its crop and largest size are ended', async () => {
    const { ply, gaussians } = strayScene();
    await restart([0.5, 0, 0.3], ['--translate', '0.5,0,0', '--rotate', '0,0,0,1'], await program.write('stray.ply', ply));
    await page.evaluate(() => document.querySelectorAll('details').forEach((d) => { d.open = true; }));
    await page.getByRole('button', { name: 'Propose a setup' }).click();
    await page.getByText(/^Crop: -?\d/).waitFor();
    await page.locator('.setup').getByRole('button', { name: 'Apply' }).click();
    const visible = gaussians.filter(({ opacity }) => opacity > 0.1).length;
    await until(page, (n) => window.palpateViewer.parameters().felt?.count === n && window.palpateViewer.kept() === n, visible - 2);
    const { filter, registration } = await current();
    assert.ok(registration.scale !== 1 && filter.max_scale > 0 && filter.opacity_min > 0);
    const middle = [0, 1, 2].map((k) => 0.5 * (filter.crop_box[k] + filter.crop_box[k + 3]));
    assert.ok(distance(middle, [0.5, 0, 0]) < 0.05, `${middle}`);
    assert.equal(await page.locator('.notice').count(), 0);
    await page.getByText(/^Gaussians outside the crop box or larger than .* are dropped\.$/).waitFor();
    await page.getByRole('button', { name: 'Keep all Gaussians' }).click();
    await until(page, (n) => window.palpateViewer.kept() === n, visible);
    const after = (await current()).filter;
    assert.deepEqual([after.max_scale, after.crop_box], [0, []]);
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
      await restart(at, [...options, '--model', 'density']);
      const { tool, drawn } = await until(page, (kept) => {
        const v = window.palpateViewer;
        const drawn = v.contacts().map((c) => ({ ...c, drawn: v.centreOfDrawnContact(c.id), felt: v.feltScale(c.id) }));
        // Until its list has come, that of the program before is drawn, whose ellipsoids are half as large again.
        const isItsList = drawn.some(({ scale, felt }) => felt && Math.abs(felt[0] / scale[0] - 1) < 0.1);
        return v.drawnContacts() > 0 && v.kept() === kept && isItsList && { tool: v.tool(), drawn };
      }, await program.kept(options));
      const found = new Map((await program.query(tool, options)).contacts.map((c) => [c.id, c.center]));
      assert.equal(await page.getByText('opacity of 0.7').count(), options.includes('--iso') ? 1 : 0);
      let compared = 0;
      for (const { id, center, scale, drawn: where, felt } of drawn) {
        if (!where || !found.has(id)) continue; // touched at one of the two instants only
        assert.ok(distance(where, center) < 1e-4);
        assert.ok(distance(where, found.get(id)) < 1e-4, `${id}: ${where}, not ${found.get(id)}`);
        felt.forEach((size, k) => assert.ok(Math.abs(size / scale[k] - 1) < 1e-3, `${id}: ${felt}, not ${scale}`));
        ++compared;
      }
      assert.ok(compared > 0);
    });
  }
});

describe('in a headset', () => {
  // WebXR's x, y, z of a point of the world, as a small scene is put first: its middle is half a metre ahead.
  const put = ([x, y, z]) => page.evaluate((p) => window.headset.controllers.right.position.set(...p), [x, 1.1 + z, -(0.5 + y)]);
  const trigger = (value) => page.evaluate((v) => window.headset.controllers.right.updateButtonValue('trigger', v), value);

  test('the controller feels the surface, the more the deeper, and nothing after it has left', async () => {
    await restart(above);
    await page.setViewportSize({ width: 480, height: 360 });
    await page.getByRole('button', { name: 'VR', exact: true }).click();
    await until(page, () => window.palpateViewer.presenting);
    await settle(page); // until then the session has no controllers
    const begin = async () => {
      await trigger(0);
      await until(page, () => !window.palpateViewer.held);
    };
    await undisturbed(async () => {
      await put(above);
      await trigger(1);
      await until(page, () => window.palpateViewer.held);
      const first = (await ask(page, (v) => v.pulses)).length;
      const meanAbove = async (least, height) => {
        const before = (await ask(page, (v) => v.pulses)).length;
        await put([0, 0, height]);
        await untilFelt(([since, force]) => {
          const pulses = window.palpateViewer.pulses.slice(since).slice(-6); // of this height, and steady
          const forces = pulses.map((p) => p.force);
          return window.palpateViewer.pulses.length > since + 10 && pulses.every((p) => p.kind !== 'click')
            && Math.min(...forces) > force && Math.max(...forces) - Math.min(...forces) < 0.01;
        }, [before, least]);
        const last = (await ask(page, (v) => v.pulses)).filter((p) => p.kind === 'hum').slice(-4);
        return { force: last.at(-1).force, intensity: last.reduce((sum, p) => sum + p.intensity, 0) / last.length };
      };
      const light = await meanAbove(0, 0.18);
      const firm = await meanAbove(1.2 * light.force, 0.14);
      assert.ok(firm.intensity > light.intensity, JSON.stringify([light, firm]));
      assert.equal((await ask(page, (v) => v.pulses))[first].kind, 'click');
      await untilFelt(() => window.palpateViewer.drawnContacts() > 0);
      await put(above);
      await until(page, () => window.palpateViewer.drawnContacts() === 0 && Math.hypot(...(window.palpateViewer.force() ?? [1])) < 0.05);
      const count = (await ask(page, (v) => v.pulses)).length;
      await settle(page, 5);
      assert.equal((await ask(page, (v) => v.pulses)).length, count);
      await trigger(0);
    }, begin);
  });
});
