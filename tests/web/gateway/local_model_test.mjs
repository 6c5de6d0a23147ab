// A hand on a device at the other end of a link of 20 ms each way, by the reference client in JavaScript and the program: what
// tests/network/hand.cpp is for the client in C++. A relay makes the link, and cuts it.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { createInterface } from 'node:readline';
import { after, before, describe, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { WebSocket } from 'ws';
import { makeFolder, start } from './palpate.mjs';

const { LocalRenderer, PalpateClient, WrenchGovernor } = await import(pathToFileURL(process.env.PALPATE_CLIENT));

const delay = 20; // ms, each way
const floor = 0.17; // m, where a ball of 2 cm touches the sphere of 15 cm
const [above, touching, pressed] = [0.005, -0.006, -0.012]; // m, over the floor, where the hand wants to be
const stiffness = 500; // N/m, of the surface, as it is set
const damping = 2; // N s/m, of device and hand together

const wait = (ms) => new Promise((done) => { setTimeout(done, ms); });
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

/// A device in a hand: a mass on the hand's spring, which goes where the hand wants it to at 0.05 m/s.
class Hand {
  static mass = 0.2; // kg
  static spring = 300; // N/m
  static speed = 0.05; // m/s
  static resolution = 1e-5; // m, of the device's encoders

  z = floor + above;
  velocity = 0;
  target = floor + above;
  workOfForce = 0; // J
  absorbed = 0; // J

  move(goal, force, seconds) {
    const steps = Math.ceil(seconds / 25e-6);
    const dt = seconds / steps;
    for (let k = 0; k < steps; k += 1) {
      this.target += Math.max(-Hand.speed * dt, Math.min(Hand.speed * dt, goal - this.target));
      this.velocity += dt * (Hand.spring * (this.target - this.z) - damping * this.velocity + force) / Hand.mass;
      this.z += dt * this.velocity;
      this.workOfForce += force * dt * this.velocity;
      this.absorbed += dt * damping * this.velocity ** 2;
    }
  }

  get measured() {
    return Hand.resolution * Math.round(this.z / Hand.resolution);
  }
}

/// Asks a relay for the program, and knows when the newest local model came, not before the client does.
class WatchedSocket extends WebSocket {
  static host = '';
  static modelCame = -Infinity; // s

  constructor(url) {
    super(url, { headers: { Host: WatchedSocket.host } });
    queueMicrotask(() => this.addEventListener('message', ({ data }) => {
      if (data.includes('/palpate/client/local_model')) WatchedSocket.modelCame = PalpateClient.now();
    }));
  }
}

/// In real time: a force is on for as long as it takes until the next.
class Trial {
  hand = new Hand();
  client;
  force = 0;
  #t = PalpateClient.now();

  constructor(client) {
    this.client = client;
  }

  /// Goes to `goal` and stays. All that was on the way.
  async stay(goal, seconds) {
    const ticks = [];
    for (const end = PalpateClient.now() + seconds; this.#t < end; await wait(1)) {
      const t = PalpateClient.now();
      this.hand.move(goal, this.force, t - this.#t);
      this.#t = t;
      const z = this.hand.measured;
      this.force = this.client.wrenchAt([0, 0, z]).force[2];
      this.client.send({ position: [0, 0, z], orientation: [1, 0, 0, 0] }, t);
      ticks.push({ t, z: this.hand.z, force: this.force, modelCame: WatchedSocket.modelCame });
    }
    return ticks;
  }

  /// At rest: medians of windows of 0.2 s.
  async #rest(goal) {
    await this.stay(goal, 1);
    const windows = [];
    for (let k = 0; k < 5; k += 1) windows.push(await this.stay(goal, 0.2));
    const ticks = windows.flat();
    return {
      z: median(ticks.map(({ z }) => z)),
      force: median(ticks.map(({ force }) => force)),
      least: Math.min(...ticks.map(({ force }) => force)),
      swing: median(windows.map((w) => Math.max(...w.map(({ z }) => z)) - Math.min(...w.map(({ z }) => z)))),
    };
  }

  /// Onto the floor, and deeper, until it has lain at both depths with a force. A machine that stands still for a moment drops
  /// it: then again, but where `drops` are part of what is measured.
  async press({ drops = false } = {}) {
    for (let k = 0; k < 20; k += 1) {
      await this.stay(floor + above, 1.5);
      const first = await this.#rest(floor + touching);
      const second = await this.#rest(floor + pressed);
      if (!drops && Math.min(first.least, second.least) === 0) continue;
      return { swing: second.swing, stiffness: (second.force - first.force) / (first.z - second.z) };
    }
    return assert.fail('no force that lasts');
  }
}

// In virtual time, on a floor at z = floor.
for (const period of [1e-3, 4e-3]) {
  test(`a hand rests on a local model that is rendered every ${1e3 * period} ms`, () => {
    const hand = new Hand();
    const renderer = new LocalRenderer({ forceMax: 12, damping });
    const planes = [{ point: [0, 0, floor], normal: [0, 0, 1] }];
    const ends = [Infinity, -Infinity];
    let force = 0;
    for (let t = 0; t < 4; t += period) {
      hand.move(floor + (t < 0.5 ? above : pressed), force, period);
      const place = [0, 0, hand.measured];
      const asked = renderer.ask({ position: place, planes, stiffness, damping: 0, friction: 0, share: 1 }, place, t);
      renderer.show(asked);
      [,, force] = asked;
      if (t > 3) ends.splice(0, 2, Math.min(ends[0], hand.z), Math.max(ends[1], hand.z));
    }
    assert.ok(ends[1] - ends[0] < 5e-5, `swings by ${ends[1] - ends[0]} m`);
    assert.ok(Math.abs(force / (floor - hand.z) / stiffness - 1) < 0.02, `${force} N`);
    assert.ok(hand.workOfForce < hand.absorbed, 'passive');
  });
}

describe('a hand at the other end of a link of 20 ms each way', () => {
  let scene;
  let palpate;
  let relay;
  let trial;
  before(async () => {
    scene = makeFolder();
    palpate = await start(scene.folder, '--device', 'client', '--client-rate', '60', '--tool', '0.02,0.02,0.02',
      '--stiffness', String(stiffness));
  });
  after(() => {
    relay?.kill('SIGKILL');
    palpate.kill();
    scene.remove();
  });

  const begin = async (limits) => {
    trial?.client.disconnect();
    relay?.kill('SIGKILL');
    await wait(1200); // the program lets go of a client that is silent for a second
    const { host, hostname, port } = new URL(palpate.url);
    WatchedSocket.host = host;
    relay = spawn('python3', [process.env.PALPATE_RELAY, '127.0.0.1', '0', hostname, port, delay, 0, 0],
      { stdio: ['ignore', 'pipe', 'inherit'] });
    const [ready] = await once(createInterface({ input: relay.stdout }), 'line');
    const client = new PalpateClient({ forceMax: 12, WebSocket: WatchedSocket, ...limits });
    await client.connect(`ws://127.0.0.1:${ready.split(' ')[1]}/`);
    trial = new Trial(client);
  };
  const say = (t, { swing, stiffness: felt }) => t.diagnostic(`felt ${felt.toFixed(0)} N/m, swings by ${(1e6 * swing).toFixed(0)} um, ` +
    `put out ${(1e3 * trial.hand.workOfForce).toFixed(1)} mJ, absorbed ${(1e3 * trial.hand.absorbed).toFixed(1)} mJ`);

  test('feels a soft surface without the local model', async (t) => {
    await begin({});
    const rest = await trial.press({ drops: true });
    say(t, rest);
    assert.ok(rest.stiffness < 0.2 * stiffness, `${rest.stiffness} N/m`);
  });

  test('rests on the surface that was set with it', async (t) => {
    await begin({ damping });
    const rest = await trial.press();
    say(t, rest);
    assert.ok(Math.abs(rest.stiffness / stiffness - 1) < 0.15, `${rest.stiffness} N/m`);
    assert.ok(rest.swing < 1e-4, `${rest.swing} m`);
    assert.ok(trial.hand.workOfForce < trial.hand.absorbed, 'passive');
  });

  test('feels nothing 50 ms after the last model where the link is cut, and then nothing but through the gate', async (t) => {
    await trial.press();
    relay.kill('SIGSTOP');
    const cut = await trial.stay(floor + pressed, 0.4);
    assert.ok(cut[0].force > 1, `${cut[0].force} N`);
    const silent = cut.filter(({ t: at, modelCame }) => at - modelCame >= WrenchGovernor.silence);
    assert.ok(silent.length > 0);
    silent.forEach(({ t: at, force, modelCame }) => assert.equal(force, 0, `${at - modelCame} s after the last model`));
    const { t: last } = cut.findLast(({ force }) => force !== 0);
    t.diagnostic(`zero ${(1e3 * (last - cut[0].t)).toFixed(0)} ms after the cut`);
    relay.kill('SIGCONT');
    const back = await trial.stay(floor + pressed, 0.5);
    assert.ok(back.at(-1).modelCame > last, 'models come again');
    back.forEach(({ force }) => assert.equal(force, 0, 'pressed, no gate opens'));
  });

  test('feels nothing 5 ms after the connection is lost', async () => {
    await trial.press();
    let lost = Infinity;
    trial.client.addEventListener('close', () => { lost = PalpateClient.now(); });
    relay.kill('SIGKILL');
    const ticks = await trial.stay(floor + pressed, 0.3);
    assert.ok(ticks[0].force > 1, `${ticks[0].force} N`);
    const first = ticks.find(({ t }) => t >= lost); // the call that sees it
    assert.ok(first);
    ticks.filter(({ t }) => t >= first.t + WrenchGovernor.fall + 1e-3).forEach(({ force }) => assert.equal(force, 0));
    assert.equal(ticks.at(-1).force, 0);
    assert.equal(trial.client.isConnected, false);
  });
});
