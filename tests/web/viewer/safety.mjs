// A stop stops, wherever it comes from, and is seen; what is old is no force.

import assert from 'node:assert/strict';
import { before, beforeEach, describe, test } from 'node:test';

import { ask, settle, until, waitFor } from './browser.mjs';
import { clear, desk, folder, openDesk, openSection, requests, resetDesk, touching } from './desk.mjs';
import { MockGateway } from './mock_gateway.mjs';

const stopped = () => desk.page.getByText('Resume when it is safe').waitFor();

describe('safety', () => {
  before(openDesk);
  beforeEach(() => resetDesk());

  test('the button and Escape stop and never resume; Resume brings the force back', async () => {
    const stop = desk.page.getByRole('button', { name: 'Emergency stop' });
    await stop.click();
    await stopped();
    await stop.click();
    await desk.page.keyboard.press('Escape');
    await waitFor(() => requests('emergency_stop').length === 3, 'three stops');
    assert.equal(requests('resume').length, 0);
    await desk.page.locator('#resume').click();
    await waitFor(() => requests('resume').length === 1, 'resume');
    await desk.page.locator('[data-field=stiffness]').first().focus();
    await desk.page.keyboard.press('Escape');
    await waitFor(() => requests('emergency_stop').length === 4, 'a stop while a field has the focus');
  });

  test('a stop is seen wherever one looks', async () => {
    await desk.page.keyboard.press('Escape');
    await stopped();
    assert.match(await desk.page.title(), /^Stopped/);
    assert.equal(await desk.page.evaluate(() => getComputedStyle(document.getElementById('view'), '::after').borderTopWidth), '8px');
    await desk.page.locator('#resume').click();
    await desk.page.locator('#stopped').waitFor({ state: 'hidden' });
    assert.doesNotMatch(await desk.page.title(), /Stopped/);
    assert.equal(await desk.page.evaluate(() => getComputedStyle(document.getElementById('view'), '::after').content), 'none');
  });

  test('a force that waits for the tool to be lifted is no riddle', async () => {
    desk.gateway.fault = { level: 0, state: 'waiting', fault: 'none', advice: '' };
    await desk.page.getByText('once the tool touches nothing').waitFor();
    assert.deepEqual(await desk.page.evaluate(() => [document.getElementById('state').dataset.level, document.getElementById('resume').hidden]), ['waiting', true]);
    desk.gateway.fault = { level: 0, state: 'active', fault: 'none', advice: '' };
    await desk.page.locator('#stopped').waitFor({ state: 'hidden' });
  });

  test('Escape in a dialogue or a measurement cancels that and nothing else', async () => {
    await desk.page.keyboard.press('?');
    await desk.page.getByRole('dialog').waitFor();
    await desk.page.keyboard.press('Escape');
    await desk.page.getByRole('dialog').waitFor({ state: 'hidden' });
    await openSection('Placement');
    await desk.page.locator('[data-action=measure]').click();
    await desk.page.getByText('Click the first point.').waitFor();
    await desk.page.keyboard.press('Escape');
    await desk.page.getByText('Click the first point.').waitFor({ state: 'hidden' });
    await desk.page.locator('[data-action=measure]').click();
    const [x, y] = await ask(desk.page, (v) => v.project([0, 0, 0]));
    await desk.page.mouse.click(x, y);
    await desk.page.getByText('Click the second point.').waitFor();
    await desk.page.keyboard.press('Escape');
    await desk.page.getByText('Click the second point.').waitFor({ state: 'hidden' });
    assert.equal(requests('emergency_stop').length, 0);
    await desk.page.keyboard.press('?');
    await desk.page.locator('#keys-close').click();
    await desk.page.keyboard.press('Escape');
    await waitFor(() => requests('emergency_stop').length === 1, 'with nothing open it stops');
  });

  test('Escape stops while the tool is on its way', async () => {
    await desk.page.keyboard.press('c');
    await until(desk.page, () => window.palpateViewer.approaching);
    await desk.page.keyboard.press('Escape');
    await waitFor(() => requests('emergency_stop').length === 1, 'a stop');
  });

  test('pausing and resuming', async () => {
    await desk.page.getByRole('button', { name: 'Pause' }).click();
    await desk.page.locator('#pause').getByText('Resume').click();
    await waitFor(() => requests('pause').length === 2, 'both');
    assert.deepEqual(requests('pause').map((r) => r.args.data), [true, false]);
  });

  test('what is old is no force: it goes out when the program falls silent', async () => {
    desk.gateway.tool.position = touching;
    await until(desk.page, () => window.palpateViewer.arrow() !== null);
    desk.gateway.muted = true;
    await until(desk.page, () => window.palpateViewer.force() === null && window.palpateViewer.arrow() === null
      && window.palpateViewer.drawnContacts() === 0 && document.body.classList.contains('stale'));
  });

  test('it comes back after a restart, without anyone, and says so meanwhile', async () => {
    const { port } = desk.gateway;
    await desk.gateway.stop();
    await desk.page.waitForFunction(() => document.getElementById('state').textContent === 'disconnected');
    assert.equal(await ask(desk.page, (v) => v.connected), false);
    await desk.page.locator('#stop').click();
    await desk.page.getByText('Stop not confirmed').waitFor();
    desk.gateway = await new MockGateway(folder, desk.scene).start(port);
    desk.gateway.tool.position = touching;
    await until(desk.page, () => window.palpateViewer.connected && window.palpateViewer.force() !== null && window.palpateViewer.drawnContacts() > 0);
    // Nothing that was asked for before arrives late but the stop.
    await desk.page.getByText('Stop not confirmed').waitFor({ state: 'hidden' });
    assert.deepEqual(desk.gateway.requests.map((r) => r.service), ['/palpate/emergency_stop']);
    await stopped();
    await desk.page.locator('#resume').click();
    await desk.page.locator('#stopped').waitFor({ state: 'hidden' });
    desk.gateway.tool.position = clear;
    await settle(desk.page);
  });

  test('a stop that is lost with its connection is sent again, once', async () => {
    desk.gateway.breaksOff = '/palpate/emergency_stop';
    await desk.page.locator('#stop').click();
    await desk.page.getByText('Stop not confirmed').waitFor();
    await stopped();
    await desk.page.getByText('Stop not confirmed').waitFor({ state: 'hidden' });
    assert.equal(requests('emergency_stop').length, 2);
    await desk.page.locator('#resume').click();
    await desk.page.locator('#stopped').waitFor({ state: 'hidden' });
    desk.gateway.breaksOff = '/palpate/pause'; // drops the connection: what was confirmed is not repeated
    await desk.page.getByRole('button', { name: 'Pause' }).click();
    await waitFor(() => requests('pause').length === 1, 'a pause');
    await until(desk.page, () => !window.palpateViewer.connected);
    await until(desk.page, () => window.palpateViewer.connected);
    await settle(desk.page);
    assert.equal(requests('emergency_stop').length, 2);
    assert.equal(requests('pause').length, 1);
  });

  test('a stop is not forgotten for a resume that was sent before it and answered after', async () => {
    await desk.page.locator('#stop').click();
    await stopped();
    desk.gateway.holdsBack = '/palpate/resume';
    desk.gateway.breaksOff = '/palpate/emergency_stop';
    await desk.page.locator('#resume').click();
    await waitFor(() => requests('resume').length === 1, 'a resume');
    await desk.page.locator('#stop').click();
    await waitFor(() => requests('emergency_stop').length === 3, 'the stop, once more');
    await stopped();
  });

  test('where there is no WebGL, it says so, and still stops; a token in the address goes along', async () => {
    desk.gateway.token = 'secret';
    const other = await desk.browser.newPage();
    await other.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
    await other.goto(`${desk.gateway.url}?token=secret`);
    await other.getByText('this needs WebGL 2').waitFor();
    await other.getByRole('button', { name: 'Pause' }).waitFor();
    await other.keyboard.press('Escape');
    await other.getByText('Resume when it is safe').waitFor();
    await other.close();
    assert.equal(requests('emergency_stop').length, 1);
  });
});
