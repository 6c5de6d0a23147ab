// The node palpate_ros2 with several hands, each with a driver of its own on Fast DDS; how fast, and how many messages are lost.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { ddsType, encode } from './messages.mjs';
import { Driver, PRESSED, Program, eventually, makeFolder, makeWall, poseMessage, triggerRequest, wait } from './program.mjs';

const kMarkers = 'visualization_msgs/MarkerArray';
const kArray = 'std_msgs/Float64MultiArray';
const kSoft = 60; // so soft that no delay makes it softer. Unit: [N/m].
const kDeep = 0.02 - PRESSED; // that a ball is pressed in. Unit: [m]
const near = (a, b, by) => assert.ok(Math.abs(a - b) <= by, `${a} is not ${b}`);

describe('several hands', () => {
  let node;
  let wall;
  const drivers = {};
  const watcher = () => drivers.first;

  before(async () => {
    const folder = makeFolder();
    wall = makeWall(folder);
    const flat = join(folder, 'flat.toml');
    writeFileSync(flat, 'device = "ros2:/wide,force_max=8,rate=60"\ntool = [0.1, 0.1, 0.02]\n');
    node = new Program(process.env.PALPATE_ROS2, '--ros-args', '-p', `scene:=${wall.path}`, '-p', 'no_index_file:=true',
      '-p', 'tool:=[0.02, 0.02, 0.02]', '-p', 'device:=/omni,force_max=8,rate=60', '-p', `stiffness:=${kSoft}`,
      '-p', `hands:=["left", "flat=${flat}"]`, '-p', `left.stiffness:=${kSoft / 2}`, '-p', 'left.device:=/left,force_max=8,rate=60');
    for (const [name, prefix] of [['first', '/omni'], ['left', '/left'], ['flat', '/wide']]) drivers[name] = new Driver(prefix);
    watcher().tell(`reader diagnostics rt/diagnostics ${ddsType('diagnostic_msgs/DiagnosticArray')} reliable`);
    watcher().tell(`reader tf rt/tf ${ddsType('tf2_msgs/TFMessage')} reliable`);
    watcher().tell(`reader flat rt/palpate/flat/contacts ${ddsType(kMarkers)} reliable`);
    watcher().tell(`reader left rt/palpate/left/contacts ${ddsType(kMarkers)} reliable`);
    watcher().tell(`reader model rt/left/palpate/local_model ${ddsType(kArray)} reliable`);
    for (const of of ['', 'left/'])
      watcher().tell(`writer ${of}stop rq/palpate/${of}emergency_stopRequest std_srvs::srv::dds_::Trigger_Request_ reliable`);
    await eventually(async () => await watcher().number('matched left/stop') > 0 && await watcher().number('matched stop') > 0, 'services');
  });
  after(async () => {
    for (const driver of Object.values(drivers)) await driver.kill();
    assert.equal(await node.end(), 0, node.said);
  });

  const forceOf = (name) => drivers[name].force();
  async function status(name) {
    const array = await watcher().newest('diagnostics', 'diagnostic_msgs/DiagnosticArray');
    const found = array?.status.find((one) => one.name === name);
    return found && { level: Number(found.level), ...Object.fromEntries(found.values.map((v) => [v.key, v.value])) };
  }
  /** At rest, again where a busy machine has let go. */
  async function feels(name, force, by) {
    let last;
    for (let k = 0; k < 5; k += 1) {
      await lean(name);
      for (let l = 0; l < 50; l += 1) {
        last = await forceOf(name);
        if (Math.abs(last - force) <= by) return;
        await wait(20);
      }
    }
    assert.fail(`${name} feels ${last}, not ${force}`);
  }
  const lean = (name) => drivers[name].lean(0.9 * (kSoft / 2) * kDeep);

  test('each feels for itself', async () => {
    await feels('left', kDeep * kSoft / 2, 0.05 * kDeep * kSoft);
    assert.equal(await forceOf('first'), 0);
    assert.equal(await forceOf('flat'), 0);
    assert.ok((await watcher().newest('left', kMarkers)).markers.length > 0);
    await feels('first', kDeep * kSoft, 0.05 * kDeep * kSoft);
  });

  test('a hundred contacts are read back', async () => {
    await lean('flat');
    const spheres = async () => (await watcher().newest('flat', kMarkers))?.markers.filter((m) => m.ns === 'contacts' && m.action === 0) ?? [];
    await eventually(async () => (await spheres()).length >= 100, 'a hundred contacts');
    const found = await spheres();
    console.log(`${found.length} contacts read back`);
    for (const m of found) {
      [m.pose.position.x, m.pose.position.y, m.pose.position.z].forEach((at, k) => near(at, wall.rows[m.id][k], 1e-6));
      const sizes = [m.scale.x, m.scale.y, m.scale.z].sort((a, b) => a - b);
      [...wall.rows[m.id].slice(7, 10)].sort((a, b) => a - b).forEach((log, k) => near(sizes[k], 2 * Math.exp(log), 1e-6));
    }
  });

  test('frames and states are told of each', async () => {
    const { transforms } = await watcher().newest('tf', 'tf2_msgs/TFMessage');
    assert.deepEqual(transforms.map((t) => t.child_frame_id).sort(), ['palpate/device', 'palpate/flat/device', 'palpate/flat/proxy',
      'palpate/flat/tool', 'palpate/left/device', 'palpate/left/proxy', 'palpate/left/tool', 'palpate/proxy', 'palpate/scene', 'palpate/tool']);
    for (const of of ['', '/left', '/flat'])
      for (const what of ['servo', 'device', 'scene']) assert.ok(await status(`palpate${of}: ${what}`), of + what);
  });

  test('a local model is the surface about the handle', async () => {
    await feels('left', kDeep * kSoft / 2, 0.05 * kDeep * kSoft);
    let layout;
    let data;
    await eventually(async () => {
      ({ layout, data } = await watcher().newest('model', kArray));
      return data[8] === 1 && Math.abs(data[4] - PRESSED) < 1e-4;
    }, 'a model at rest');
    assert.deepEqual([layout.data_offset, layout.dim.map((d) => [d.label, d.size, d.stride])],
      [9, [['planes', 1, 6], ['point, normal', 6, 6]]]);
    assert.equal(data.length, 15);
    near(data[0] + 1e-9 * data[1], Date.now() / 1000, 5);
    const [x, y, z, stiffness, , friction, share] = data.subarray(2, 9);
    near(z, PRESSED, 1e-3);
    assert.deepEqual([x, y, stiffness, friction, share], [0, 0, kSoft / 2, 0, 1]);
    near(stiffness * (data[11] - z) * data[14], kDeep * kSoft / 2, 0.05 * kDeep * kSoft); // the force itself, from the plane alone
  });

  test('what befalls one hand leaves the others, and each has its stop', async () => {
    /** Whether the first hand presses as before while the poses of another are bad. */
    const undisturbed = async () => {
      await lean('left');
      await feels('first', kDeep * kSoft, 0.01 * kDeep * kSoft);
      await wait(300); // until it is at rest
      const before_ = await forceOf('first');
      drivers.left.bad(poseMessage('base', NaN));
      await drivers.left.noForce();
      await eventually(async () => (await status('palpate/left: device')).level === 2, 'an error of that hand');
      const kept = Math.abs(await forceOf('first') - before_) <= 1e-3 * before_ && (await status('palpate: device')).level < 2;
      drivers.left.good();
      return kept;
    };
    let kept = false; // a machine that stands still takes the force of all
    for (let k = 0; k < 4 && !kept; k += 1) kept = await undisturbed();
    assert.ok(kept, node.said);
    await node.says('hand left: ros2:/left: poses of');
    await lean('left');
    const ask = (name, number) => watcher().tell(`send ${name} ${triggerRequest(7n, number)}`);
    ask('left/stop', 1n);
    await drivers.left.noForce();
    assert.ok(await forceOf('first') > 0);
    ask('stop', 2n);
    await drivers.first.noForce();
    await drivers.flat.noForce();
  });
});

test('palpate run has several drivers, too', async (context) => {
  const folder = makeFolder();
  const { path } = makeWall(folder);
  const file = join(folder, 'left.toml');
  writeFileSync(file, `device = "ros2:/left,force_max=8,rate=60"\nstiffness = ${kSoft / 2}\n`);
  const palpate = new Program(process.env.PALPATE, 'run', path, '--no-gateway', '--no-index-file', '--tool', '0.02,0.02,0.02',
    '--stiffness', String(kSoft), '--device', 'ros2:/omni,force_max=8,rate=60', '--hands', `left=${file}`);
  const first = new Driver('/omni');
  const left = new Driver('/left');
  context.after(async () => {
    await first.kill();
    await left.kill();
    assert.equal(await palpate.end(), 0, palpate.said);
  });
  await left.lean(0.9 * (kSoft / 2) * kDeep);
  assert.equal(await first.force(), 0);
  await first.lean(0.9 * kSoft * kDeep);
  await left.kill();
  await palpate.says('hand left: no force: stale-pose');
  assert.ok(await first.force() > 0);
});

describe('how fast, and how many are lost', () => {
  for (const reliability of ['reliable', 'best_effort']) {
    test(reliability, async (context) => {
      const { path } = makeWall(makeFolder());
      const node = new Program(process.env.PALPATE_ROS2, '--ros-args', '-p', `scene:=${path}`, '-p', 'no_index_file:=true',
        '-p', 'tool:=[0.02, 0.02, 0.02]', '-p', 'device:=/omni,force_max=8,rate=60');
      const driver = new Driver('/omni', reliability);
      context.after(async () => {
        await driver.kill();
        assert.equal(await node.end(), 0, node.said);
      });
      driver.tell(`reader diagnostics rt/diagnostics ${ddsType('diagnostic_msgs/DiagnosticArray')} reliable`);
      const counts = async () => {
        const array = await driver.newest('diagnostics', 'diagnostic_msgs/DiagnosticArray');
        return Object.fromEntries(array?.status.find((one) => one.name === 'palpate: device')?.values.map((v) => [v.key, Number(v.value)]) ?? []);
      };
      await eventually(async () => (await counts()).taken > 500, 'poses');
      await driver.ask('trips spatial');
      /** Of poses, once none is on its way. */
      const still = async () => {
        driver.tell('mute 1');
        await wait(500);
        const { taken, dropped } = await counts();
        return [await driver.number('sent'), taken + dropped];
      };
      const [sentBefore, cameBefore] = await still();
      const lostBefore = await driver.number('lost spatial');
      driver.tell('mute 0');
      await driver.ask('trips spatial');
      driver.tell('clear spatial');
      const begin = Date.now();
      await wait(5000);
      const [sent, answered, p50, p99] = (await driver.ask('trips spatial')).split(' ').map(Number);
      const wrenches = await driver.number('count spatial');
      const seconds = (Date.now() - begin) / 1000;
      const lost = await driver.number('lost spatial') - lostBefore;
      const [sentAfter, cameAfter] = await still();
      console.log(`${reliability}: poses ${(sent / seconds).toFixed(0)} Hz, lost ${sentAfter - sentBefore - (cameAfter - cameBefore)} of `
        + `${sentAfter - sentBefore}; wrenches ${(wrenches / seconds).toFixed(0)} Hz, lost ${lost} of ${wrenches + lost}; `
        + `answered ${answered} of ${sent}; round trip p50 ${p50.toFixed(2)} ms, p99 ${p99.toFixed(2)} ms`);
      assert.ok(answered > 100);
    });
  }
});

/** A node with a wall and these parameters besides, and a driver for it; both end with the test. */
function nodeWith(context, ...more) {
  const driver = new Driver('/omni');
  const node = new Program(process.env.PALPATE_ROS2, '--ros-args', '-p', `scene:=${makeWall(makeFolder()).path}`, '-p', 'no_index_file:=true',
    '-p', 'tool:=[0.02, 0.02, 0.02]', '-p', 'device:=/omni,force_max=8,rate=20', ...more);
  context.after(async () => {
    await driver.kill();
    node.process.kill('SIGKILL');
  });
  return { node, driver };
}

test('two hands that are mapped onto one device have no force', async (context) => {
  const maps = ['measured_cp', 'spatial/servo_cf', 'body/servo_cf'].flatMap((name) => ['-r', `/left/${name}:=/omni/${name}`]);
  const { node, driver } = nodeWith(context, '-p', 'hands:=left', '-p', 'left.device:=/left', ...maps);
  await node.says('publishes wrenches for the device, too', 2);
  driver.tell(`to ${PRESSED}`);
  for (let k = 0; k < 100; k += 1) {
    assert.equal(await driver.force(), 0);
    await wait(10);
  }
  assert.equal(await node.end(), 0, node.said);
});

test('a terminal that nobody reads holds up neither poses nor a stop', async (context) => {
  const { node, driver } = nodeWith(context);
  driver.tell(`writer set rt/palpate/set_parameters ${ddsType('std_msgs/String')} reliable`);
  driver.tell('writer stop rq/palpate/emergency_stopRequest std_srvs::srv::dds_::Trigger_Request_ reliable');
  await eventually(async () => await driver.number('matched set') > 0 && await driver.number('matched stop') > 0, 'services');
  node.process.stderr.pause();
  const nonsense = encode('string data', { data: `{"nonsense": ${'x'.repeat(500)}` }); // each is a line on the terminal
  for (let k = 0; k < 3000; k += 1) {
    driver.tell(`send set ${nonsense}`);
    await wait(1);
  }
  await driver.lean();
  driver.tell(`send stop ${triggerRequest(7n, 1n)}`);
  await driver.noForce();
  assert.equal(await node.end(), 0);
});

// Long ones come faster than they can be read, so that the node is never done with them.
test('a flood of settings delays no stop', async (context) => {
  const { node, driver } = nodeWith(context);
  const other = new Driver('/other', 'reliable', false);
  context.after(() => other.kill());
  other.tell(`writer set rt/palpate/set_parameters ${ddsType('std_msgs/String')} reliable`);
  other.tell(`body ${encode('string data', { data: `{"stiffness": 300${' '.repeat(50000)}}` })} -1 -1`);
  driver.tell('writer stop rq/palpate/emergency_stopRequest std_srvs::srv::dds_::Trigger_Request_ reliable');
  await eventually(async () => await other.number('matched set') > 0 && await driver.number('matched stop') > 0, 'services');
  other.tell('walk set 10000');
  await driver.lean();
  const begin = Date.now();
  driver.tell(`send stop ${triggerRequest(7n, 1n)}`);
  await driver.noForce();
  assert.ok(Date.now() - begin < 500, `after ${Date.now() - begin} ms`);
  assert.equal(await node.end(), 0, node.said);
});
