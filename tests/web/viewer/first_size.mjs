// A scene that does not say how large it is gets a size, which is said and can be changed; from there a first touch is near.

import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';

import { ask, settle, until, waitFor } from './browser.mjs';
import { desk, openDesk, requests, resetDesk } from './desk.mjs';
import { ballScene, radius } from './mock_scene.mjs';

const asked = () => requests('set_parameters').map((r) => JSON.parse(r.args.json));
const card = () => desk.page.locator('#size');
// How large the ball is on the page. Unit: [px].
const shown = () => ask(desk.page, (v, r) => {
  const size = v.parameters().registration.scale * r;
  const [a, b] = [-size, size].map((s) => v.project(v.axes().right.map((c) => s * c)));
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}, radius);

async function openUnknown(parameters = {}) {
  const scene = ballScene(320 + unknown++); // of which the page knows nothing
  await resetDesk({ scene, parameters: { registration: { assumed: ['scale', 'frame'] }, ...parameters } });
}
let unknown = 0;

describe('the first size', () => {
  before(openDesk);
  after(() => resetDesk());

  test('is what is proposed, is said, and fills the view', async () => {
    await openUnknown();
    await waitFor(() => asked().length === 1, 'the size');
    assert.deepEqual(asked(), [{ registration: { scale: 0.25, frame: 'y-down' } }]);
    await desk.page.getByText(/does not state its scale\. .* across and upright, to suit the size of the tool/).waitFor();
    const [, said] = /now ([\d.]+) cm across/.exec(await card().textContent());
    assert.ok(Math.abs(said / (100 * 0.25 * 2 * radius * Math.sqrt(3)) - 1) < 0.1, `${said} cm from corner to corner`);
    await settle(desk.page, 4);
    const { height } = await desk.page.locator('#canvas').boundingBox();
    assert.ok(await shown() > 0.2 * height, `${await shown()} of ${height} px`);
    const ring = desk.page.locator('.tool-ring');
    const isLarge = await ask(desk.page, (v) => v.toolPixels());
    assert.ok(isLarge >= 24 || (await ring.boundingBox()).width >= 24, `the tool is ${isLarge} px large`);
  });

  test('is changed with one slider, once that is let go', async () => {
    const before = asked().length;
    await card().getByRole('slider', { name: 'Size of the scene' }).evaluate((node) => {
      for (const value of [600, 650, 700]) {
        node.value = value;
        node.dispatchEvent(new Event('input'));
      }
      node.dispatchEvent(new Event('change'));
    });
    await waitFor(() => asked().length === before + 1, 'one change');
    const { scale } = desk.gateway.parameters.registration;
    assert.ok(Math.abs(scale / (0.25 * 30 ** 0.4) - 1) < 0.02, `${scale}`);
    await card().getByText(/^The scene is now .* across\.$/).waitFor();
    await settle(desk.page, 4);
    const { height } = await desk.page.locator('#canvas').boundingBox();
    assert.ok(await shown() > 0.2 * height && await shown() < height, 'it is seen whole again');
    await card().getByRole('button', { name: 'As captured' }).click();
    await waitFor(() => desk.gateway.parameters.registration.scale === 1, 'the size in the file');
    await card().getByRole('button', { name: 'Keep this size' }).click();
    assert.equal(await card().isVisible(), false);
  });

  test('is asked for again where the connection is lost before the answer comes', async () => {
    desk.gateway.breaksOff = '/palpate/propose_setup';
    await openUnknown();
    await waitFor(() => asked().length === 1, 'the size');
    assert.equal(requests('propose_setup').length, 2);
    await card().getByText(/across/).waitFor();
  });

  test('is not given while somebody has taken the tool meanwhile, which is said', async () => {
    const scene = ballScene(320 + unknown++);
    await resetDesk();
    desk.gateway.beforeProposal = () => desk.gateway.change({ registration: { assumed: [] } });
    const { beforeProposal } = desk.gateway;
    desk.gateway.reset(desk.gateway.tool.position, scene, { registration: { assumed: ['scale'] } });
    desk.gateway.beforeProposal = beforeProposal;
    await desk.page.getByText('The scene keeps the size of its file').waitFor();
    assert.deepEqual(asked(), []);
  });

  test('is not looked for where somebody has said one, or a device has a hand of its own', async () => {
    await openUnknown({ registration: { assumed: [] } });
    await settle(desk.page, 4);
    await openUnknown({ demo: undefined });
    await settle(desk.page, 4);
    assert.deepEqual(requests('propose_setup'), []);
    assert.equal(await card().isVisible(), false);
  });
});
