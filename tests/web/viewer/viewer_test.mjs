// The viewer page against a stand-in for the program, which can fail on demand.

import assert from 'node:assert/strict';
import { after, afterEach, before, beforeEach, describe, test } from 'node:test';

import { ask, launch, openViewer, pixel, settle, until } from './browser.mjs';
import { MockGateway } from './mock_gateway.mjs';
import { radius } from './mock_scene.mjs';

const folder = process.env.VIEWER_FOLDER;
const touching = [0, 0, radius + 0.012]; // the mock's tool is 8 mm deep there
const clear = [0, 0, 0.3];
const right = [0.78, 0.62, 0].map((c) => c / Math.hypot(0.78, 0.62)); // of the camera as it looks first

let browser;
let gateway;
let page;
let problems;

const service = (name) => gateway.requests.filter((r) => r.service === `/palpate/${name}`);
const distance = (a, b) => Math.hypot(...a.map((c, k) => c - b[k]));
const openSection = (title) => page.evaluate((text) => {
  [...document.querySelectorAll('details')].find((d) => d.querySelector('summary').textContent === text).open = true;
}, title);

async function waitFor(condition, what) {
  for (const end = Date.now() + 30000; Date.now() < end;) {
    if (condition()) return;
    await new Promise((done) => { setTimeout(done, 20); });
  }
  assert.fail(`did not come: ${what}`);
}

before(async () => { browser = await launch(); });
after(() => browser.close());

async function open() {
  gateway = await new MockGateway(folder).start();
  gateway.tool.position = clear;
  ({ page, problems } = await openViewer(browser, gateway.url));
}

async function close() {
  await page.close();
  await gateway.stop();
  assert.deepEqual(problems, []);
}

function onPagesOfTheirOwn() {
  beforeEach(open);
  afterEach(close);
}

/// For tests that leave nothing behind but what the program says and what is held: opening a page takes seconds.
function onOnePage() {
  before(open);
  after(close);
  afterEach(async () => {
    await page.evaluate(() => {
      document.activeElement.blur();
      window.dispatchEvent(new Event('blur')); // lets the tool go
    });
    gateway.reset(clear);
    await page.getByRole('button', { name: 'Pause' }).waitFor();
    await until(page, ([stiffness, z]) => window.palpateViewer.parameters().stiffness === stiffness && !window.palpateViewer.held
      && window.palpateViewer.tool()[2] === z, [gateway.parameters.stiffness, clear[2]]);
  });
}

describe('what is seen', () => {
  onPagesOfTheirOwn();

  test('the scene is where the program says, in the colours of the file', async () => {
    await page.getByRole('button', { name: 'Frame all' }).click();
    await settle(page);
    // Along the camera's right, just inside and just outside the outline of the ball.
    const colorAt = async (share) => pixel(page, await ask(page, (v, p) => v.project(p), right.map((c) => share * radius * c)));
    const [orange, blue] = [await colorAt(0.9), await colorAt(-0.9)];
    assert.ok(orange[0] > orange[2] + 60, `orange, not ${orange}`);
    assert.ok(blue[2] > blue[0] + 60, `blue, not ${blue}`);
    for (const share of [-1.15, 1.15]) {
      const color = await colorAt(share);
      assert.ok(Math.max(...color) - Math.min(...color) < 20, `background, not ${color}`);
    }
  });

  test('a registration moves and scales the scene', async () => {
    const off = [0.5, 0, 0];
    const seen = async () => {
      const color = await pixel(page, await ask(page, (v, p) => v.project(p), [0, -radius, 0]));
      return Math.max(...color) - Math.min(...color) > 60;
    };
    for (let k = 0; !(await seen()); k += 1) { // drawn as soon as it is sorted
      assert.ok(k < 100, 'the ball is not at the origin before');
      await settle(page, 1);
    }
    gateway.change({ registration: { scale: 0.5, translation: off } });
    await until(page, () => window.palpateViewer.parameters().registration.scale === 0.5);
    await page.getByRole('button', { name: 'Frame all' }).click();
    await settle(page, 8);
    const color = await pixel(page, await ask(page, (v, p) => v.project(p), [0.5 + 0.04, -0.029, 0]));
    assert.ok(color[0] > color[2] + 60, `orange, not ${color}`);
  });

  test('what can be felt is what the opacity cut keeps, and is drawn when asked for', async () => {
    const faint = gateway.gaussians.filter((g) => g.opacity < 0.1).length;
    assert.equal(await ask(page, (v) => v.kept()), gateway.gaussians.length - faint);
    assert.equal(await ask(page, (v) => v.felt()), 0);
    await page.locator('[data-toggle=felt]').check();
    await until(page, (n) => window.palpateViewer.felt() === n, gateway.gaussians.length - faint);
    gateway.change({ filter: { opacity_min: 0.01, sigma: 1 } });
    await until(page, (n) => window.palpateViewer.felt() === n, gateway.gaussians.length);
  });

  test('the scene comes back when the graphics card has lost it', async () => {
    const seen = async () => {
      const color = await pixel(page, await ask(page, (v, p) => v.project(p), [0, -radius, 0]));
      return Math.max(...color) - Math.min(...color) > 60;
    };
    const become = async (is) => {
      for (let k = 0; (await seen()) !== is; k += 1) {
        assert.ok(k < 100, `the ball is ${is ? 'not ' : ''}seen`);
        await settle(page, 1);
      }
    };
    await become(true);
    await page.evaluate(() => {
      window.loss = document.getElementById('canvas').getContext('webgl2').getExtension('WEBGL_lose_context');
      window.loss.loseContext();
    });
    await become(false);
    await page.evaluate(() => window.loss.restoreContext());
    await become(true);
  });

  test('contacts light up where they are, and go out', async () => {
    gateway.tool.position = touching;
    await until(page, () => window.palpateViewer.drawnContacts() > 0);
    const expected = gateway.contacts;
    await until(page, (n) => window.palpateViewer.drawnContacts() === n, expected.length);
    for (const { row, center, scale } of expected) {
      const drawn = await ask(page, (v, id) => v.centreOfDrawnContact(id), row);
      assert.ok(distance(drawn, center) < 1e-4, `contact ${row} is drawn ${distance(drawn, center)} m away`);
      const told = (await ask(page, (v) => v.contacts())).find((c) => c.id === row);
      assert.ok(distance(told.scale, scale) < 1e-9);
    }
    gateway.tool.position = clear;
    await until(page, () => window.palpateViewer.drawnContacts() === 0);
  });

  test('the arrow points where the force does', async () => {
    gateway.tool.position = [0.06, -0.06, 0.06];
    const arrow = await (await until(page, () => window.palpateViewer.arrow())).jsonValue();
    const outward = gateway.tool.position.map((c) => c / Math.hypot(...gateway.tool.position));
    assert.ok(distance(arrow, outward) < 1e-3, `${arrow}`);
  });
});

describe('holding the tool', () => {
  onOnePage();

  const toolOnPage = () => ask(page, (v) => v.project(v.tool()));

  test('the tool follows a drag and is let go with the button', async () => {
    const [x, y] = await toolOnPage();
    await page.mouse.move(x, y);
    await page.mouse.down();
    assert.equal(await ask(page, (v) => v.held), true);
    await page.mouse.move(x + 60, y + 40, { steps: 4 });
    await waitFor(() => gateway.poses.length > 0 && distance(gateway.tool.position, clear) > 0.02, 'poses');
    await page.waitForFunction(([tx, ty]) => {
      const at = window.palpateViewer.project(window.palpateViewer.tool());
      return Math.hypot(at[0] - tx, at[1] - ty) < 3;
    }, [x + 60, y + 40]);
    assert.match(await page.locator('#holder').textContent(), /you hold the tool/);
    const { header, pose } = gateway.poses.at(-1);
    assert.ok(Math.abs(header.stamp.secs - Date.now() / 1000) < 5 && header.stamp.nsecs < 1e9 && header.frame_id === 'world');
    assert.ok(Math.abs(Math.hypot(...Object.values(pose.orientation)) - 1) < 1e-9);
    await page.mouse.up();
    assert.equal(await ask(page, (v) => v.held), false);
    await settle(page);
    const sent = gateway.poses.length;
    await settle(page, 5);
    assert.equal(gateway.poses.length, sent);
    await waitFor(() => !gateway.isHeld, 'the hand is free again');
    await page.waitForFunction(() => /simulated hand/.test(document.getElementById('holder').textContent));
  });

  test('keys move it while Hold is on, and the wheel goes into depth', async () => {
    await page.getByRole('button', { name: 'Hold' }).click();
    await page.keyboard.down('PageUp');
    await waitFor(() => distance(gateway.tool.position, clear) > 0.01, 'a step by key');
    await page.keyboard.up('PageUp');
    await settle(page);
    const before = gateway.tool.position;
    await page.mouse.move(200, 300);
    await page.mouse.wheel(0, 300); // towards the camera
    await waitFor(() => distance(gateway.tool.position, before) > 0.01, 'a step by wheel');
    assert.ok(gateway.tool.position[1] < before[1]); // where the camera is
    await page.getByRole('button', { name: 'Hold' }).click();
    assert.equal(await ask(page, (v) => v.held), false);
  });

  test('who is refused is told that someone else holds it', async () => {
    gateway.refusePoses = true;
    await page.getByRole('button', { name: 'Hold' }).click();
    await page.waitForFunction(() => /someone else/.test(document.getElementById('holder').textContent));
    assert.equal(gateway.poses.length, 0);
  });

  test('a drag beside the tool turns the view instead', async () => {
    const before = await toolOnPage();
    await page.mouse.move(60, 500);
    await page.mouse.down();
    await page.mouse.move(160, 480, { steps: 3 });
    await page.mouse.up();
    assert.ok(distance(await toolOnPage(), before) > 5);
    assert.equal(gateway.poses.length, 0);
  });
});

describe('panels', () => {
  onOnePage();

  const field = (name) => page.locator(`[data-field="${name}"]`);

  test('a stiffness that is typed changes the force', async () => {
    gateway.tool.position = touching;
    await until(page, () => Math.hypot(...(window.palpateViewer.force() ?? [0])) > 1);
    const before = await ask(page, (v) => Math.hypot(...v.force()));
    await field('stiffness').first().fill('1000');
    await field('stiffness').first().press('Enter');
    await until(page, (b) => Math.abs(Math.hypot(...(window.palpateViewer.force() ?? [0])) - 2 * b) < 0.01 * b, before);
    assert.equal(await field('stiffness').first().inputValue(), '1000');
  });

  test('a refusal is shown, and the field goes back', async () => {
    gateway.refusal = 'stiffness: above what the device can hold';
    await field('stiffness').first().fill('4000');
    await field('stiffness').first().press('Enter');
    await page.getByText('above what the device can hold').waitFor();
    await page.locator('#canvas').focus();
    await page.waitForFunction(() => document.querySelector('[data-field="stiffness"]').value === '500');
  });

  test('what cannot be is not asked for, but said', async () => {
    for (const [name, wrong, right, said] of [['stiffness', '6000', '500', /^Stiffness: .*5000/], ['friction', '', '0', /^Friction: .+/]]) {
      await field(name).first().fill(wrong);
      await field(name).first().press('Enter');
      await page.getByText(said).waitFor();
      assert.equal(await field(name).first().inputValue(), right);
    }
    assert.equal(service('set_parameters').length, 0);
  });

  test('another viewer sees a change', async () => {
    const other = await openViewer(browser, gateway.url);
    await field('model').selectOption('density');
    await until(other.page, () => document.querySelector('[data-field="model"]').value === 'density');
    await other.page.close();
    assert.deepEqual(other.problems, []);
  });

  test('semi-axes are set in millimetres', async () => {
    await openSection('Tool');
    await field('semi_axes-2').fill('55');
    await field('semi_axes-2').press('Enter');
    await waitFor(() => gateway.parameters.tool[0].semi_axes[2] === 0.055, 'the tool');
    assert.deepEqual(gateway.parameters.tool[0].semi_axes.slice(0, 2), [0.02, 0.02]);
  });

  test('a tool file is sent as text', async () => {
    const toml = '[[ellipsoid]]\nname = "tip"\nsemi_axes = [0.01, 0.01, 0.01]\n';
    await field('tool_file').setInputFiles({ name: 'tip.toml', mimeType: 'application/toml', buffer: Buffer.from(toml) });
    await waitFor(() => service('load_tool').length === 1, 'the file');
    assert.equal(service('load_tool')[0].args.data, toml);
  });

  test('two clicked points and their distance give the scale', async () => {
    await openSection('Placement');
    const on = (n) => n.map((c) => (c * radius) / Math.hypot(...n));
    const points = [on([0.8, -0.6, 0]), on([0.3, -0.8, 0.5])];
    await page.locator('[data-action=measure]').click();
    for (const point of points) {
      const [x, y] = await ask(page, (v, p) => v.project(p), point);
      await page.mouse.click(x, y);
    }
    await field('true_distance').fill(String(2000 * distance(...points)));
    await field('true_distance').press('Enter');
    await waitFor(() => gateway.parameters.registration.scale !== 1, 'a scale');
    assert.ok(Math.abs(gateway.parameters.registration.scale - 2) < 0.1, `${gateway.parameters.registration.scale}`);
  });

  test('frames, rotation and translation are set', async () => {
    await openSection('Placement');
    await page.locator('[data-action=frame-y-down]').focus();
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => document.activeElement.matches('[data-action=frame-y-down][aria-pressed=true]'));
    assert.equal(gateway.parameters.registration.frame, 'y-down');
    await field('rotation-2').fill('90');
    await field('rotation-2').press('Enter');
    await waitFor(() => gateway.parameters.registration.rotation[3] > 0.7, 'the rotation');
    assert.ok(distance(gateway.parameters.registration.rotation, [Math.SQRT1_2, 0, 0, Math.SQRT1_2]) < 1e-6);
  });

  test('a recording is begun and ended, and a configuration taken along', async () => {
    await openSection('Record and keep');
    await page.locator('[data-action=record]').click();
    await page.getByRole('button', { name: 'End the recording' }).click();
    await waitFor(() => service('record').length === 2, 'both');
    assert.deepEqual(service('record').map((r) => r.args.data), [true, false]);
    const [download] = await Promise.all([page.waitForEvent('download'), page.locator('[data-action=config]').click()]);
    assert.equal(download.suggestedFilename(), 'palpate.toml');
  });
});

describe('safety', () => {
  onOnePage();

  test('the button and Escape stop, and Resume brings the force back', async () => {
    await page.getByRole('button', { name: 'Emergency stop' }).click();
    await page.getByText('resume when it is safe').waitFor();
    await page.getByRole('button', { name: 'Resume' }).click();
    await waitFor(() => service('resume').length === 1, 'resume');
    await page.locator('[data-field=stiffness]').first().focus();
    await page.keyboard.press('Escape');
    await waitFor(() => service('emergency_stop').length === 2, 'a stop by key');
  });

  test('where there is no WebGL, it says so, and still stops', async () => {
    const blind = await launch({ webgl: false });
    const other = await blind.newPage();
    await other.goto(gateway.url);
    await other.getByText('this needs WebGL 2').waitFor();
    await other.getByRole('button', { name: 'Emergency stop' }).click();
    await other.getByText('resume when it is safe').waitFor();
    await blind.close();
    assert.equal(service('emergency_stop').length, 1);
  });

  test('pausing and resuming', async () => {
    await page.getByRole('button', { name: 'Pause' }).click();
    await page.getByRole('button', { name: 'Resume' }).click();
    await waitFor(() => service('pause').length === 2, 'both');
    assert.deepEqual(service('pause').map((r) => r.args.data), [true, false]);
  });

  test('what is old is no force: it goes out when the program falls silent', async () => {
    gateway.tool.position = touching;
    await until(page, () => window.palpateViewer.arrow() !== null);
    gateway.muted = true;
    await until(page, () => window.palpateViewer.force() === null && window.palpateViewer.arrow() === null
      && window.palpateViewer.drawnContacts() === 0 && document.body.classList.contains('stale'));
  });

  test('it comes back after a restart, without anyone, and says so meanwhile', async () => {
    const { port } = gateway;
    await gateway.stop();
    await page.waitForFunction(() => document.getElementById('state').textContent === 'disconnected');
    assert.equal(await ask(page, (v) => v.connected), false);
    await page.locator('#stop').click();
    await page.getByText('Not connected.').waitFor();
    gateway = await new MockGateway(folder).start(port);
    gateway.tool.position = touching;
    await until(page, () => window.palpateViewer.connected && window.palpateViewer.force() !== null);
    await until(page, () => window.palpateViewer.drawnContacts() > 0);
    assert.deepEqual(gateway.requests, []); // nothing that was asked for before arrives late
  });

  test('a token in the page’s address goes along', async () => {
    gateway.token = 'secret';
    const other = await openViewer(browser, `${gateway.url}?token=secret`);
    assert.equal(await ask(other.page, (v) => v.connected), true);
    await other.page.close();
  });
});
