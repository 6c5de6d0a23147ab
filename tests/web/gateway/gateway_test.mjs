// roslib, the client that people use, against palpate run. Nothing about how long something takes is asserted; what it
// took is printed.

import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { parse } from '@foxglove/rosmsg';
import { MessageReader } from '@foxglove/rosmsg-serialization';
import { Param, Service, Topic } from 'roslib';
import { drive, pose, quantile } from './drive.mjs';
import { connect, first, makeFolder, nextStatus, run, start, valuesOf } from './palpate.mjs';

const call = (ros, name, serviceType, request = {}) =>
  new Promise((done, failed) => new Service({ ros, name, serviceType }).callService(request, done, failed));

let scene;
before(() => { scene = makeFolder(); });
after(() => scene.remove());

describe('a client that looks on', () => {
  let palpate;
  let ros;
  before(async () => {
    palpate = await start(scene.folder, '--tool', '0.02,0.02,0.02');
    ros = await connect(palpate.url);
  });
  after(async () => {
    ros.close();
    const summary = await palpate.stop();
    assert.ok(summary.ticks > 100);
  });

  test('finds topics and services with their types', async () => {
    const { topics, types } = await new Promise((done, failed) => ros.getTopics(done, failed));
    assert.equal(types[topics.indexOf('/palpate/measured_cp')], 'geometry_msgs/PoseStamped');
    assert.equal(types[topics.indexOf('/palpate/contacts')], 'visualization_msgs/MarkerArray');
    const services = await new Promise((done, failed) => ros.getServices(done, failed));
    assert.ok(services.includes('/palpate/pause'));
    const type = await new Promise((done, failed) => ros.getTopicType('/palpate/tool', done, failed));
    assert.equal(type, 'visualization_msgs/MarkerArray');
    assert.deepEqual(await new Promise((done, failed) => ros.getNodes(done, failed)), ['/palpate']);
  });

  test('is told what every topic and service is made of', async () => {
    const ask = (name, ...args) => new Promise((done, failed) => ros[name](...args, done, failed));
    const defs = await ask('getMessageDetails', 'geometry_msgs/PoseStamped');
    assert.deepEqual(defs.map(({ type }) => type), ['geometry_msgs/PoseStamped', 'std_msgs/Header', 'time', 'geometry_msgs/Pose',
      'geometry_msgs/Point', 'geometry_msgs/Quaternion']);
    assert.deepEqual(defs[4], { type: 'geometry_msgs/Point', fieldnames: ['x', 'y', 'z'], fieldtypes: ['float64', 'float64', 'float64'],
      fieldarraylen: [-1, -1, -1], examples: ['0.0', '0.0', '0.0'], constnames: [], constvalues: [] });
    const { header, pose } = ros.decodeTypeDefs(defs);
    assert.deepEqual(header, { seq: 'uint32', stamp: 'time', frame_id: 'string' });
    assert.deepEqual(Object.keys(pose.orientation), ['x', 'y', 'z', 'w']);
    const array = ros.decodeTypeDefs(await ask('getMessageDetails', 'diagnostic_msgs/DiagnosticArray'));
    assert.deepEqual(Object.keys(array.status[0]), ['level', 'name', 'message', 'hardware_id', 'values']);

    const { types } = await ask('getTopics');
    for (const type of types) assert.equal((await ask('getMessageDetails', type))[0].type, type);
    const services = await ask('getServices');
    for (const name of services) {
      const type = await ask('getServiceType', name);
      assert.equal((await ask('getServiceRequestDetails', type)).typedefs[0].type, `${type}Request`);
      assert.equal((await ask('getServiceResponseDetails', type)).typedefs[0].type, `${type}Response`);
    }
    const { typedefs } = await ask('getServiceRequestDetails', 'std_srvs/SetBool');
    assert.deepEqual(ros.decodeTypeDefs(typedefs), { data: 'bool' });
    await assert.rejects(ask('getMessageDetails', 'no_msgs/Nothing'), (why) => why === "there is no message type 'no_msgs/Nothing'");
    await assert.rejects(ask('getServiceRequestDetails', 'std_msgs/String'), (why) => /no service type/.test(why));
  });

  for (const compression of ['none', 'cbor']) {
    test(`gets every topic (${compression})`, async () => {
      const options = { compression };
      const tool = await first(ros, '/palpate/measured_cp', 'geometry_msgs/PoseStamped', undefined, options);
      const q = tool.pose.orientation;
      assert.ok(Math.abs(Math.hypot(q.x, q.y, q.z, q.w) - 1) < 1e-9);
      const markers = await first(ros, '/palpate/tool', 'visualization_msgs/MarkerArray', undefined, options);
      assert.deepEqual(markers.markers[0].scale, { x: 0.04, y: 0.04, z: 0.04 });
      const array = await first(ros, '/palpate/diagnostics', 'diagnostic_msgs/DiagnosticArray', undefined, options);
      assert.ok(Number(valuesOf(array).tick_p50_us) > 0);
      for (const [name, type] of [['measured_cv', 'geometry_msgs/TwistStamped'], ['proxy_cp', 'geometry_msgs/PoseStamped'],
        ['spatial/servo_cf', 'geometry_msgs/WrenchStamped'], ['body/servo_cf', 'geometry_msgs/WrenchStamped']])
        await first(ros, `/palpate/${name}`, type, undefined, options);
    });
  }

  // As Foxglove's rosbridge source: types and definitions first, then the bytes of ROS 1.
  test('gets every topic as ROS 1 encodes it', async () => {
    const { topics, types, typedefs_full_text: texts } = await new Promise((done, failed) => ros.getTopicsAndRawTypes(done, failed));
    const readers = new Map(topics.map((name, k) => [name, new MessageReader(parse(texts[k]))]));
    const raw = async (name, accepts) => {
      const type = types[topics.indexOf(name)];
      const read = ({ bytes }) => readers.get(name).readMessage(new Uint8Array(bytes));
      return read(await first(ros, name, type, (message) => !accepts || accepts(read(message)), { compression: 'cbor-raw' }));
    };
    const own = /^\/palpate\/(measured|spatial|body|proxy|contacts|tool|diagnostics|parameters|messages)/;
    for (const name of topics.filter((topic) => own.test(topic))) await raw(name);
    const { header, pose } = await raw('/palpate/measured_cp');
    assert.equal(header.frame_id, 'world');
    assert.ok(Math.abs(header.stamp.sec - Date.now() / 1000) < 5);
    const q = pose.orientation;
    assert.ok(Math.abs(Math.hypot(q.x, q.y, q.z, q.w) - 1) < 1e-9);
    const { markers } = await raw('/palpate/contacts', (array) => array.markers.some((m) => m.ns === 'contacts' && m.action === 0));
    const { pose: { position: p }, color } = markers.find((m) => m.ns === 'contacts' && m.action === 0);
    assert.ok(Math.abs(Math.hypot(p.x, p.y, p.z) - 0.15) < 0.02); // on the sphere
    assert.ok(color.a > 0 && color.a <= 1);
    const { status } = await raw('/palpate/diagnostics');
    assert.equal(status[0].name, 'palpate: servo');
    assert.ok(status[0].values.some(({ key, value }) => key === 'rate_hz' && Number(value) > 0));
  });

  test('sees the contacts of the exploring hand, and that they go', async () => {
    const name = '/palpate/contacts';
    const touched = await first(ros, name, 'visualization_msgs/MarkerArray',
      ({ markers }) => markers.some((m) => m.action === 0 && m.ns === 'contacts'));
    const { id, pose: { position: p } } = touched.markers.find((m) => m.ns === 'contacts' && m.action === 0);
    assert.ok(Math.abs(Math.hypot(p.x, p.y, p.z) - 0.15) < 0.02); // on the sphere
    assert.ok(touched.markers.some((m) => m.ns === 'normals' && m.id === id));
    await first(ros, name, 'visualization_msgs/MarkerArray', ({ markers }) =>
      markers.some((m) => m.id === id && m.action === 2) && !markers.some((m) => m.id === id && m.action === 0));
  });

  test('is sent fewer messages with a throttle', async () => {
    const count = async (throttle_rate) => {
      let messages = 0;
      const topic = new Topic({ ros, name: '/palpate/measured_cp', messageType: 'geometry_msgs/PoseStamped', throttle_rate });
      topic.subscribe(() => { messages += 1; });
      await new Promise((done) => { setTimeout(done, 1500); });
      topic.unsubscribe();
      return messages;
    };
    const all = await count(0);
    const few = await count(250);
    assert.ok(few >= 1 && few <= 8 && all > 2 * few, `${all} and ${few}`);
  });

  test('reads and sets parameters', async () => {
    const stiffness = new Param({ ros, name: '/palpate/stiffness' });
    assert.equal(await new Promise((done) => { stiffness.get(done); }), 500);
    const known = first(ros, '/palpate/parameters', 'std_msgs/String', ({ data }) => JSON.parse(data).stiffness === 800);
    stiffness.set(800);
    await known;
    const refused = await call(ros, '/palpate/set_parameters', 'palpate/SetParameters', { json: '{"friction": -1}' });
    assert.equal(refused.success, false);
    assert.match(refused.message, /friction/);
    const tool = await call(ros, '/palpate/load_tool', 'palpate/SetString',
      { data: '[[ellipsoid]]\nname = "a"\nsemi_axes = [0.01, 0.01, 0.01]\n' });
    assert.deepEqual(tool, { success: true, message: '' });
    await first(ros, '/palpate/tool', 'visualization_msgs/MarkerArray', ({ markers }) => markers[0].scale.x === 0.02);
    const { message } = await call(ros, '/palpate/config', 'std_srvs/Trigger');
    assert.match(message, /stiffness = 800/);
  });

  test('keeps a configuration that starts another command with the same tool', async () => {
    const ball = (name, x) => `[[ellipsoid]]\nname = ${JSON.stringify(name)}\nsemi_axes = [0.01, 0.01, 0.01]\nposition = [${x}, 0, 0]\n`;
    const names = [`it's "odd" \\ '''`, 'ümlaut'];
    const load = (data) => call(ros, '/palpate/load_tool', 'palpate/SetString', { data });
    assert.ok((await load(ball(names[0], -0.02) + ball(names[1], 0.02))).success);
    const { message } = await call(ros, '/palpate/config', 'std_srvs/Trigger');
    writeFileSync(path.join(scene.folder, 'saved.toml'), message);
    const out = run(scene.folder, 'query', 'sphere.ply', '--pose', '0,0,0.15', '--config', 'saved.toml', '--json');
    assert.deepEqual(new Set(JSON.parse(out).contacts.map(({ part }) => part)), new Set(names));
    await load(ball('a', 0));
  });

  test('is told what can be felt, and when that is something else', async () => {
    const told = async (fits) => {
      const { data } = await first(ros, '/palpate/parameters', 'std_msgs/String', (m) => fits(JSON.parse(m.data).felt));
      const { count, url, tag } = JSON.parse(data).felt;
      const answer = await fetch(new URL(url, palpate.url));
      assert.equal(answer.headers.get('etag'), `"${tag}"`);
      const list = await answer.arrayBuffer();
      assert.equal(list.byteLength, 16 * count);
      const [rows, values] = [new Uint32Array(list), new Float32Array(list)];
      const semiAxes = new Map([...Array(count).keys()].map((i) => [rows[4 * i], [...values.slice(4 * i + 1, 4 * i + 4)]]));
      assert.equal(semiAxes.size, count);
      return { tag, semiAxes };
    };
    const set = (filter) => call(ros, '/palpate/set_parameters', 'palpate/SetParameters', { json: JSON.stringify({ filter }) });
    const before = await told((felt) => felt);
    await set({ opacity_min: 0.8 });
    const faintGone = await told((felt) => felt.tag !== before.tag);
    assert.ok(faintGone.semiAxes.size > 0 && faintGone.semiAxes.size < before.semiAxes.size);
    for (const [row, axes] of faintGone.semiAxes) assert.deepEqual(axes, before.semiAxes.get(row));
    await set({ opacity_min: 0.1, sigma: 2 });
    const larger = await told((felt) => felt.tag !== faintGone.tag && felt.count === before.semiAxes.size);
    for (const [row, axes] of larger.semiAxes) assert.deepEqual(axes.map((a) => a / 2), before.semiAxes.get(row));
    await set({ sigma: 1 });
    await told((felt) => felt.tag !== larger.tag);
  });

  test('a registration moves what is touched', async () => {
    await call(ros, '/palpate/set_parameters', 'palpate/SetParameters',
      { json: '{"registration": {"scale": 2, "translation": [5, 0, 0], "mirrored": true}}' });
    const touched = await first(ros, '/palpate/contacts', 'visualization_msgs/MarkerArray',
      ({ markers }) => markers.some((m) => m.action === 0 && m.pose.position.x > 4));
    const { x, y, z } = touched.markers.find((m) => m.ns === 'contacts' && m.action === 0).pose.position;
    assert.ok(Math.abs(Math.hypot(x - 5, y, z) - 0.3) < 0.04);
    const { data } = await first(ros, '/palpate/parameters', 'std_msgs/String');
    const matrix = JSON.parse(data).registration.matrix.map((v) => v + 0); // no -0
    assert.deepEqual(matrix, [-2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 5, 0, 0, 1]);
    const { message } = await call(ros, '/palpate/config', 'std_srvs/Trigger');
    assert.match(message, /^scale = 2$/m);
    assert.match(message, /^mirror = true$/m);
    assert.match(message, /^translate = \[5, 0, 0\]$/m);
  });

  test('pauses and stops', async () => {
    const until = (fits, options) => first(ros, '/palpate/diagnostics', 'diagnostic_msgs/DiagnosticArray',
      (m) => fits(valuesOf(m)), options);
    // What the machine does meanwhile (it may stand still for a moment) may stop the loop for a graver reason than a
    // pause: then once more.
    const active = async () => {
      for (;;) {
        await call(ros, '/palpate/resume', 'std_srvs/Trigger');
        const { state } = valuesOf(await until(({ state: now, advice }) => now === 'active' || (now === 'stopped' && advice !== '')));
        if (state === 'active') return;
        await new Promise((done) => { setTimeout(done, 300); });
      }
    };
    for (let k = 0; ; k += 1) {
      await active();
      await call(ros, '/palpate/pause', 'std_srvs/SetBool', { data: true });
      const { fault } = valuesOf(await until(({ state }) => state === 'stopped'));
      if (fault === 'paused') break;
      assert.ok(k < 5, fault);
    }
    await call(ros, '/palpate/pause', 'std_srvs/SetBool', { data: false });
    await active();
    await call(ros, '/palpate/emergency_stop', 'std_srvs/Trigger');
    await until(({ state, fault }) => state === 'stopped' && fault === 'emergency-stop');
    await active();
  });

  test('records, and gets the report', async () => {
    await call(ros, '/palpate/record', 'std_srvs/SetBool', { data: true });
    await first(ros, '/palpate/contacts', 'visualization_msgs/MarkerArray', ({ markers }) => markers.length > 0);
    await call(ros, '/palpate/record', 'std_srvs/SetBool', { data: false });
    await first(ros, '/palpate/parameters', 'std_msgs/String', ({ data }) => JSON.parse(data).recorded);
    assert.match(await (await fetch(`${palpate.url}recording`)).text(), /^# \[made\]\n(#.*\n)+t,x,y,z,qw/);
    assert.match(await (await fetch(`${palpate.url}recording.html`)).text(), /<script/);
  });

  test('is told what it does wrong', async () => {
    const told = (send) => {
      const status = nextStatus(ros);
      send();
      return status;
    };
    const status = await told(() => new Topic({ ros, name: '/nobody', messageType: 'std_msgs/String' }).subscribe(() => {}));
    assert.equal(status.level, 'error');
    assert.match(status.msg, /nobody/);
    const posed = await told(() => new Topic({ ros, name: '/palpate/client/measured_cp', messageType: 'geometry_msgs/PoseStamped' })
      .publish({ ...pose(0, 0, 0), pose: { position: { x: 'here' }, orientation: {} } }));
    assert.match(posed.msg, /x/);
    await assert.rejects(call(ros, '/palpate/nothing', 'std_srvs/Trigger'));
  });
});

describe('a client that is the device', () => {
  let palpate;
  let ros;
  before(async () => {
    palpate = await start(scene.folder, '--device', 'client', '--tool', '0.02,0.02,0.02');
    ros = await connect(palpate.url);
  });
  after(async () => {
    ros.close();
    await palpate.stop();
  });

  test('gets a wrench for its poses, outward where it is pressed in', async () => {
    const times = [];
    let pushed = null;
    const end = performance.now() + 60_000;
    // Free for a second, so that the governor lets go; then 5 mm into the sphere from above; and again, as a machine
    // that stands still for a moment means no force until the tool is free.
    const height = (t) => 0.17 + 0.02 - 0.025 * Math.min(1, 2 * Math.max(0, Math.min((t % 3) - 1, 3 - (t % 3))));
    await drive(ros, (t) => [0, 0, height(t)], () => (pushed !== null && times.length > 3000) || performance.now() > end,
      (force, took) => {
        times.push(took);
        if (force.z > 1) pushed = force;
      });
    assert.ok(pushed !== null, 'no force came');
    assert.ok(pushed.z > 5 * Math.hypot(pushed.x, pushed.y), JSON.stringify(pushed));
    const [p50, p99] = [0.5, 0.99].map((share) => quantile(times, share).toFixed(3));
    console.log(`pose to wrench at 1 kHz: p50 ${p50} ms, p99 ${p99} ms of ${times.length}`);
  });

  test('has no force when it is silent, and another one may take the tool', async () => {
    await first(ros, '/palpate/diagnostics', 'diagnostic_msgs/DiagnosticArray', (m) => valuesOf(m).fault === 'stale-pose');
    const other = await connect(palpate.url);
    try {
      const taken = first(other, '/palpate/measured_cp', 'geometry_msgs/PoseStamped', (m) => m.pose.position.x === 0.7);
      const hand = new Topic({ ros: other, name: '/palpate/client/measured_cp', messageType: 'geometry_msgs/PoseStamped' });
      const timer = setInterval(() => hand.publish(pose(0.7, 0, 0)), 10);
      await taken;
      const refused = nextStatus(ros);
      new Topic({ ros, name: '/palpate/client/measured_cp', messageType: 'geometry_msgs/PoseStamped' }).publish(pose(0, 0, 1));
      assert.match((await refused).msg, /another client/);
      clearInterval(timer);
    } finally {
      other.close();
    }
  });
});
