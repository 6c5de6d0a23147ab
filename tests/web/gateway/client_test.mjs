// The reference client in JavaScript: its governor on a clock of the test's own, then all of it against a scripted server,
// and against the program.

import assert from 'node:assert/strict';
import { once } from 'node:events';
import { after, before, describe, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { WebSocket, WebSocketServer } from 'ws';
import { connect, first, makeFolder, start, valuesOf } from './palpate.mjs';

const { PalpateClient, WrenchGovernor } = await import(pathToFileURL(process.env.PALPATE_CLIENT));

const wait = (ms) => new Promise((done) => { setTimeout(done, ms); });
const along = (z) => ({ force: [0, 0, z], torque: [0, 0, 0] });
const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-9, `${a} is not ${b}`);

async function eventually(holds) {
  for (let k = 0; k < 30_000; k += 1) {
    if (holds()) return;
    await wait(1);
  }
  assert.fail(`never: ${holds}`);
}

describe('the governor of a client', () => {
  const begin = () => {
    const governor = new WrenchGovernor({ forceMax: 10, torqueMax: 0.5 });
    const on = { governor, now: 100 };
    on.show = () => governor.show(on.now).force[2];
    on.take = (z) => governor.take(along(z), on.now, on.now);
    on.hold = (z, seconds) => {
      let shown = 0;
      for (const end = on.now + seconds; on.now < end; on.now += 1e-3) {
        on.take(z);
        shown = on.show();
      }
      return shown;
    };
    on.open = () => {
      on.hold(0, 0.002);
      on.hold(4, WrenchGovernor.rise);
      on.take(4);
      assert.equal(on.show(), 4);
    };
    return on;
  };

  test('shows nothing before the first wrench', () => assert.equal(begin().show(), 0));

  test('falls in a line to zero at 50 ms of silence, and not to come back by itself', () => {
    const on = begin();
    on.open();
    const last = on.now;
    for (const [age, force] of [[0.0449, 4], [0.0451, 4], [0.04755, 2], [0.05, 0], [1, 0]]) {
      on.now = last + age;
      near(on.show(), force);
    }
    assert.equal(on.hold(4, 1), 0);
  });

  test('wants a small wrench first, and then rises in 100 ms', () => {
    const on = begin();
    on.open();
    on.now += 0.06;
    on.show();
    assert.equal(on.hold(0.6, 0.1), 0);
    on.take(0.4);
    assert.equal(on.show(), 0);
    for (const opened = on.now; on.now < opened + 0.2; on.now += 1e-3) {
      on.take(4);
      near(on.show(), 4 * Math.min(1, (on.now - opened) / 0.1));
    }
  });

  test('is zero 5 ms after what is not finite, or a failure', () => {
    const on = begin();
    for (const bad of [() => on.take(NaN), () => on.take(Infinity), () => on.take(undefined), () => on.take('4'),
      () => on.governor.take({ force: [0, 0, 4], torque: [0, NaN, 0] }, on.now, on.now), () => on.governor.fail()]) {
      on.open();
      bad();
      assert.equal(on.show(), 4);
      on.now += 0.0025;
      near(on.show(), 2);
      on.now += 0.0026;
      assert.equal(on.show(), 0);
      assert.equal(on.hold(4, 1), 0);
    }
  });

  test('clamps in the direction that was asked for', () => {
    const on = begin();
    on.open();
    on.governor.take({ force: [30, 0, 40], torque: [0, -3, 4] }, on.now, on.now);
    const { force, torque } = on.governor.show(on.now);
    [force[0] - 6, force[2] - 8, torque[1] + 0.3, torque[2] - 0.4].forEach((x) => near(x, 0));
    on.take(1e308);
    near(on.show(), 10);
  });

  test('counts silence from the pose that is answered', () => {
    const on = begin();
    on.open();
    const measured = on.now;
    for (; on.now < measured + 0.0449; on.now += 1e-3) {
      on.governor.take(along(4), measured, on.now);
      assert.equal(on.show(), 4);
    }
    on.now = measured + 0.05;
    on.governor.take(along(4), measured, on.now);
    assert.equal(on.show(), 0);
    on.open();
    on.now += 0.06;
    on.show();
    for (let k = 0; k < 2; k += 1) {
      on.governor.take(along(0), NaN, on.now);
      on.show();
    }
    assert.equal(on.hold(4, 0.1), 0);
  });

  test('goes through the gate where nobody has asked it for 50 ms', () => {
    const on = begin();
    on.open();
    for (let k = 0; k < 60; k += 1, on.now += 1e-3) on.take(4);
    assert.equal(on.show(), 0); // at once: the motors may have been switched off meanwhile
    assert.equal(on.hold(4, 0.1), 0);
  });

  test('goes through the gate where the clock was set back', () => {
    const on = begin();
    on.open();
    on.now -= 3600;
    on.take(4);
    assert.equal(on.show(), 0);
    assert.equal(on.hold(4, 0.1), 0);
  });

  test('counts a silence that no call has seen', () => {
    const on = begin();
    on.open();
    on.now += 0.04;
    assert.equal(on.show(), 4);
    on.now += 0.02;
    on.take(4);
    on.show();
    assert.equal(on.hold(4, 0.1), 0);
  });

  test('opens for no wrench from before a failure, nor for a torque that is not small', () => {
    const on = begin();
    on.open();
    on.hold(0.3, 0.01);
    on.governor.fail();
    for (const end = on.now + 0.04; on.now < end; on.now += 1e-3) on.show();
    assert.equal(on.show(), 0);
    for (let k = 0; k < 100; k += 1, on.now += 1e-3) {
      on.governor.take({ force: [0, 0, 0], torque: [0.03, 0, 0] }, on.now, on.now);
      assert.equal(on.governor.show(on.now).torque[0], 0);
    }
  });

  test('is zero within 5 ms where the handle is nowhere, however that is said', () => {
    for (const nowhere of [null, undefined, [], [0, 0], [0, NaN, -0.003], ['0', '0', '0'], 'abc', 7, {}]) {
      const governor = new WrenchGovernor({ forceMax: 12, damping: 1 });
      const model = { planes: [{ point: [0, 0, 0], normal: [0, 0, 1] }], stiffness: 500, damping: 0, friction: 0, share: 1 };
      let now = 100;
      const tick = (z, place) => {
        now += 1e-3;
        governor.takeModel({ ...model, position: [0, 0, z] }, now, now);
        return governor.showAt(place, now).force[2];
      };
      for (let k = 0; k < 150; k += 1) tick(0.001, [0, 0, 0.001]);
      let last = 0;
      for (let k = 10; k >= -30; k -= 1) last = tick(1e-4 * k, [0, 0, 1e-4 * k]);
      near(last, 1.5);
      for (let k = 0; k < 5; k += 1) assert.ok(tick(-0.003, nowhere) <= 1.5);
      assert.equal(tick(-0.003, nowhere), 0);
    }
  });

  test('refuses limits that are none', () => {
    for (const limits of [{}, { forceMax: 0 }, { forceMax: NaN }, { forceMax: 1, torqueMax: -1 }])
      assert.throws(() => new WrenchGovernor(limits), RangeError);
  });
});

describe('a client and a scripted server', () => {
  let server;
  let peer;
  let heard;
  let client;
  before(async () => {
    server = new WebSocketServer({ host: '127.0.0.1', port: 0 });
    await once(server, 'listening');
  });
  after(() => server.close());

  const url = () => `ws://127.0.0.1:${server.address().port}/`;
  const published = (topic) => heard.filter((m) => m.op === 'publish' && m.topic === `/palpate/client/${topic}`).map((m) => m.msg);
  const begin = async (again = null, topics = 2) => {
    client?.disconnect();
    heard = [];
    const came = once(server, 'connection');
    client = again ?? new PalpateClient({ forceMax: 12, WebSocket });
    await client.connect(url());
    [peer] = await came;
    peer.on('message', (text) => heard.push(JSON.parse(text)));
    await eventually(() => heard.length === topics);
  };
  const wrench = (z) => {
    const now = Math.round(1e9 * PalpateClient.now());
    const header = { stamp: { secs: Math.floor(now / 1e9), nsecs: now % 1e9 }, frame_id: 'device' };
    const msg = { header, wrench: { force: { x: 0, y: 0, z }, torque: { x: 0, y: 0, z: 0 } } };
    return JSON.stringify({ op: 'publish', topic: '/palpate/client/servo_cf', msg });
  };
  const hold = async (z, seconds) => {
    let shown = 0;
    for (const end = performance.now() + 1000 * seconds; performance.now() < end; await wait(1)) {
      peer.send(wrench(z));
      shown = client.wrench.force[2];
    }
    return shown;
  };
  const open = async () => {
    for (let k = 0; k < 50; k += 1) {
      await hold(0, 0.02);
      if (await hold(5, 0.15) === 5) return;
    }
    assert.fail('no force');
  };

  test('subscribes, sends stamped poses, and answers echoes with its own clock', async () => {
    await begin();
    assert.deepEqual(heard.map(({ op, topic }) => [op, topic]),
      [['subscribe', '/palpate/client/servo_cf'], ['subscribe', '/palpate/client/echo']]);
    client.send({ position: [0.1, 0.2, 0.3], orientation: [0.5, -0.5, 0.5, -0.5] }, 12.25);
    await eventually(() => published('measured_cp').length === 1);
    assert.deepEqual(published('measured_cp')[0], {
      header: { stamp: { secs: 12, nsecs: 250_000_000 }, frame_id: 'device' },
      pose: { position: { x: 0.1, y: 0.2, z: 0.3 }, orientation: { w: 0.5, x: -0.5, y: 0.5, z: -0.5 } },
    });
    const asked = PalpateClient.now();
    peer.send('{"op":"publish","topic":"/palpate/client/echo","msg":{"seq":7,"stamp":{"secs":1,"nsecs":2},"frame_id":""}}');
    await eventually(() => published('echoed').length === 1);
    const { seq, stamp } = published('echoed')[0];
    assert.equal(seq, 7);
    const said = stamp.secs + 1e-9 * stamp.nsecs;
    assert.ok(said > asked - 1e-6 && said < PalpateClient.now() + 1e-6, `${asked}, ${said}`);
  });

  test('shows nothing after what is no message, until a wrench is small', async () => {
    await begin();
    const bad = ['', '{', 'null', '7', '[]', '{}', Buffer.from([1, 2]), wrench(5).replace('"z":5', '"z":1e999'),
      wrench(5).replace('"z":5', '"z":null'), wrench(5).replace('"z":5', '"z":"5"'), wrench(5).replace('"force"', '"farce"'),
      wrench(5).replace('"wrench":{', '"wench":{'), wrench(5).replace('"torque"', '"talk"'),
      '{"op":"publish","topic":"/palpate/client/servo_cf"}', '{"op":"publish","topic":"/another","msg":{}}',
      '{"op":"publish","topic":"/palpate/client/echo","msg":{"seq":-1}}'];
    for (const text of bad) {
      await open();
      peer.send(text);
      await hold(5, 0.05); // as good as before
      assert.equal(await hold(5, 0.05), 0, String(text));
      assert.ok(client.isConnected);
    }
    await open();
  });

  // A floor at z = 0, for a handle at that height.
  const localModel = (z) => JSON.stringify({
    op: 'publish',
    topic: '/palpate/client/local_model',
    msg: {
      header: JSON.parse(wrench(0)).msg.header,
      position: { x: 0, y: 0, z },
      planes: [{ point: { x: 0, y: 0, z: 0 }, normal: { x: 0, y: 0, z: 1 } }],
      stiffness: 500,
      damping: 0,
      friction: 0,
      share: 1,
    },
  });

  test('makes the force of local models itself, once the damping of the device is known', async () => {
    await begin(new PalpateClient({ forceMax: 12, damping: 2, WebSocket }), 3);
    assert.equal(heard[2].topic, '/palpate/client/local_model');
    let z = 0.001;
    const position = new Float64Array(3); // one, written over
    const shown = () => {
      position[2] = z;
      return client.wrenchAt(position).force[2];
    };
    const press = async (to, seconds) => {
      for (const end = performance.now() + 1000 * seconds; performance.now() < end; await wait(1)) {
        z += Math.max(-1e-4, Math.min(1e-4, to - z));
        peer.send(localModel(z));
        shown();
      }
      return shown();
    };
    const open = async () => {
      for (let k = 0; k < 50; k += 1) {
        await press(0.001, 0.15);
        if (await press(-0.002, 0.1) > 0.999) return;
      }
      assert.fail('no force');
    };
    const part = (name, value) => localModel(-0.002).replace(new RegExp(`"${name}":[^,}]*`), `"${name}":${value}`);
    const bad = [part('stiffness', -1), part('share', 2), part('friction', '"0"'), part('damping', null), part('x', '1e999'), part('x', 1e307),
      localModel(-0.002).replace(/"planes":.*?}]/, '"planes":7'), localModel(-0.002).replace(/"planes":.*?}]/, '"planes":[null]'),
      localModel(-0.002).replace('"z":1}', '"z":2}')];
    for (const text of bad) {
      await open();
      peer.send(text);
      await press(-0.002, 0.05);
      assert.equal(await press(-0.002, 0.02), 0, text);
    }
    await open();
  });

  test('shows nothing where the server is silent or gone, and does not connect by itself', async () => {
    await begin();
    await open();
    await eventually(() => client.wrench.force[2] === 0);
    await open();
    const closed = once(client, 'close');
    peer.terminate();
    await closed;
    assert.equal(client.isConnected, false);
    client.send({ position: [9, 9, 9], orientation: [1, 0, 0, 0] });
    await eventually(() => client.wrench.force[2] === 0);
    await wait(200);
    assert.equal(server.clients.size, 0);
    await begin(client);
    peer.send(wrench(0));
    await wait(50);
    assert.equal(heard.length, 2, 'what was measured before is not sent');
    await open();
    client.disconnect();
    assert.ok(client.wrench.force[2] > 0, 'the line begins');
    await wait(10);
    assert.equal(client.wrench.force[2], 0);
  });

  test('never has a queue of old poses', async () => {
    await begin();
    peer._socket.pause();
    const most = 100_000;
    for (let k = 1; k <= most; k += 1) {
      client.send({ position: [k, 0, 0], orientation: [1, 0, 0, 0] });
      if (k % 100 === 0) await new Promise((done) => { setImmediate(done); });
    }
    peer._socket.resume();
    await eventually(() => {
      peer.send(wrench(0)); // what waits goes with the next occasion
      return heard.at(-1).msg?.pose.position.x === most;
    });
    assert.ok(heard.length < most / 2, `${heard.length}, but for what the kernel keeps`);
  });

  test('tells what it is told, and why there is no connection', async () => {
    await begin();
    const told = once(client, 'status');
    peer.send('{"op":"status","level":"error","msg":"another client holds the tool"}');
    assert.equal((await told)[0].detail, 'another client holds the tool');
    client.disconnect();
    await assert.rejects(client.connect('ws://127.0.0.1:1/'), /127\.0\.0\.1:1/);
    assert.equal(client.isConnected, false);
    assert.throws(() => new PalpateClient({ forceMax: 1, WebSocket: null }), TypeError);
  });
});

describe('a client and the program', () => {
  let scene;
  let palpate;
  let client;
  let z;
  let speaks = true;
  let late = 0; // s
  before(async () => {
    scene = makeFolder();
    palpate = await start(scene.folder, '--device', 'client', '--tool', '0.02,0.02,0.02');
    client = new PalpateClient({ forceMax: 12, WebSocket });
    await client.connect(palpate.url.replace('http', 'ws'));
    z = 0.19;
  });
  after(() => {
    client.disconnect();
    palpate.kill();
    scene.remove();
  });

  // Goes to a height at 0.1 m/s and stays, over the sphere, which the ball touches at 0.17 m. What was shown at which time.
  const lead = async (height, seconds, until = () => false) => {
    const shown = [];
    const begin = performance.now();
    while (performance.now() < begin + 1000 * seconds && !until(shown.at(-1))) {
      z += Math.max(-1e-4, Math.min(1e-4, height - z));
      if (speaks) client.send({ position: [0, 0, z], orientation: [1, 0, 0, 0] }, PalpateClient.now() - late);
      shown.push({ t: performance.now(), force: client.wrench.force[2] });
      await wait(1);
    }
    return shown;
  };
  const [free, pressed] = [0.19, 0.165]; // m
  // Onto the sphere until there is a force; a machine that stands still for a moment is a fault: then again.
  const press = async () => {
    for (let k = 0; k < 60; k += 1) {
      await lead(free, 1.2);
      if ((await lead(pressed, 0.8, (now) => now?.force > 1)).at(-1).force > 1) return;
    }
    assert.fail('no force');
  };
  // But for what the client's gate lets pass while the program's own force falls.
  const assertNone = (shown, from) =>
    shown.filter(({ t }) => t > from).forEach(({ t, force }) => assert.ok(Math.abs(force) < 0.05, `${force} N ${t - from} ms after`));

  test('is pushed out of the sphere, with a wrench for every tick', async () => {
    await press();
    const before = client.wrenchCount;
    await lead(pressed, 1);
    assert.ok(client.wrenchCount - before > 300, `${client.wrenchCount - before} of 1000`);
  });

  test('shows nothing while the program is stopped, and after that nothing but through the gate', async () => {
    await press();
    process.kill(palpate.pid, 'SIGSTOP');
    const stopped = performance.now();
    assertNone(await lead(pressed, 0.4), stopped + 30 + 50);
    process.kill(palpate.pid, 'SIGCONT');
    assertNone(await lead(pressed, 0.5), stopped);
    await press();
  });

  test('feels no step where it was silent', async () => {
    await press();
    speaks = false;
    const silent = performance.now();
    assertNone(await lead(pressed, 0.3), silent + 50);
    speaks = true;
    assertNone(await lead(pressed, 0.5), silent);
    await press();
  });

  test('has poses that are as old as it says', async () => {
    const ros = await connect(palpate.url);
    const ageIs = async (fits) => {
      const leads = { on: true };
      const leading = (async () => { while (leads.on) await lead(free, 0.1); })();
      await first(ros, '/palpate/diagnostics', 'diagnostic_msgs/DiagnosticArray', (m) => fits(Number(valuesOf(m).age_us)));
      leads.on = false;
      await leading;
    };
    late = 0;
    await ageIs((age) => age < 10_000);
    late = 0.03;
    await ageIs((age) => age >= 30_000 && age < 50_000);
    ros.close();
  });
});
