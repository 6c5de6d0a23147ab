// palpate run --device ros2:/omni, and a driver on Fast DDS whose messages are made and read by another implementation.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { after, before, describe, test } from 'node:test';
import { ddsType, encode, typeHash } from './messages.mjs';
import { Driver, FREE, PRESSED, Peer, Program, environment, eventually, makeFolder, makeWall, poseMessage, wait } from './program.mjs';


test('types have the hashes that their definitions give', () => {
  const source = readFileSync(process.env.PALPATE_TYPE_HASHES, 'utf8');
  const found = [...source.matchAll(/"(\w+)::msg::dds_::(\w+)_",\s*"([0-9a-f]{64})"/g)];
  assert.equal(found.length, 10);
  for (const [, folder, name, hash] of found) assert.equal(hash, typeHash(`${folder}/${name}`), name);
});

describe('a driver on ROS 2', () => {
  let palpate;
  let driver;

  before(() => {
    const { path } = makeWall(makeFolder());
    palpate = new Program(process.env.PALPATE, 'run', path, '--no-gateway', '--no-index-file', '--tool', '0.02,0.02,0.02',
      '--device', 'ros2:/omni,force_max=8,rate=20');
    driver = new Driver('/omni');
  });
  after(async () => {
    await driver.kill();
    assert.equal(await palpate.end(), 0, palpate.said);
  });

  test('feels a wall, along both frames', async () => {
    await driver.lean();
    const spatial = await driver.newest('spatial', 'geometry_msgs/WrenchStamped');
    assert.equal(spatial.header.frame_id, 'base');
    assert.ok(Math.abs(spatial.header.stamp.sec - Date.now() / 1000) < 5);
    assert.ok(Math.abs(spatial.wrench.force.x) < 1e-3 && spatial.wrench.torque.z === 0);
    const body = await driver.newest('body', 'geometry_msgs/WrenchStamped');
    assert.equal(body.header.frame_id, 'tool');
    assert.ok(body.wrench.force.z > 0.5);
    await driver.ask('trips spatial');
    await wait(2000);
    const [sent, answered, p50, p99] = (await driver.ask('trips spatial')).split(' ').map(Number);
    console.log(`poses ${sent / 2} Hz, answered ${answered} of ${sent}; round trip p50 ${p50.toFixed(2)} ms, p99 ${p99.toFixed(2)} ms`);
    assert.ok(answered > 100);
  });

  /** While `breaks()` is in force and after it, there is no force, and one line has `words`. */
  async function refusesOnce(words, breaks) {
    await driver.lean();
    const lines = palpate.said.split(words).length;
    breaks();
    try {
      await palpate.says(words, lines);
      await driver.noForce();
      await wait(200);
      assert.equal(palpate.said.split(words).length, lines + 1, palpate.said);
    } finally {
      driver.good();
    }
  }

  for (const [what, words, message] of [
    ['NaN', 'no force until valid poses arrive', poseMessage('base', NaN)],
    ['another norm', 'no force until valid poses arrive', poseMessage('base', 0.016, 2)],
    ['another frame', "in the frame 'else', not 'base'", poseMessage('else', 0.016)],
  ]) {
    test(`drops ${what}, and says so once`, async () => {
      await refusesOnce(words, () => driver.bad(message));
      assert.equal((await driver.newest('spatial', 'geometry_msgs/WrenchStamped')).header.frame_id, 'base');
    });
  }

  for (const stamp of [{ sec: 0, nanosec: 0xffffffff }, { sec: -1, nanosec: 0 }, { sec: 0x7fffffff, nanosec: 999999999 }]) {
    test(`drops the stamp ${stamp.sec}.${stamp.nanosec}`, async () => {
      const message = poseMessage('base', 0.016);
      message.header.stamp = stamp;
      await refusesOnce('have invalid stamps and are dropped',
        () => driver.tell(`body ${encode('geometry_msgs/PoseStamped', message)} -1 -1`));
    });
  }

  test('drops what is late', async () => {
    await driver.lean();
    driver.tell('late 0.5');
    await driver.noForce();
    await palpate.says('late, repeated or out of order');
    driver.tell('late 0');
    await driver.lean();
  });

  test('drops poses with stamps in the future, until its clock is known to be set', async () => {
    await driver.lean();
    driver.tell('late -5');
    await palpate.says('stamps in the future');
    driver.tell('late 0');
    await driver.lean();
  });

  test('does not feel a second publisher', async (context) => {
    const other = new Driver('/omni');
    context.after(() => other.kill());
    await palpate.says('controls the device until it is silent for 1 s; stop one');
  });

  for (const along of ['spatial', 'body']) {
    test(`has no force while another publishes wrenches along the ${along} frame`, async (context) => {
      await driver.lean();
      const before_ = palpate.said.split('publishes wrenches for the device, too').length;
      const other = new Peer();
      context.after(() => other.kill());
      other.tell(`writer wrench rt/omni/${along}/servo_cf ${ddsType('geometry_msgs/WrenchStamped')} reliable`);
      await palpate.says('publishes wrenches for the device, too', before_);
      await driver.noForce();
      await wait(200);
      assert.equal(await driver.force(), 0);
      other.process.stdin.end();
      await other.ended;
      await driver.lean();
    });
  }

  test('lets the force fall where the driver is killed, and feels the next one', async () => {
    await driver.lean();
    await driver.kill();
    await palpate.says('stale-pose');
    driver = new Driver('/omni', 'best_effort');
    await driver.lean();
  });

  test('shows nothing to a subscriber that comes in contact, beside the driver', async (context) => {
    await driver.lean();
    const other = new Peer();
    context.after(() => other.kill());
    other.tell(`reader other rt/omni/spatial/servo_cf ${ddsType('geometry_msgs/WrenchStamped')} reliable`);
    const newest = () => other.newest('other', 'geometry_msgs/WrenchStamped');
    await eventually(newest, 'a wrench');
    for (let k = 0; k < 20; k += 1) {
      assert.equal((await newest()).wrench.force.z, 0);
      await wait(50);
    }
    assert.equal(await driver.force(), 0);
    await driver.lean();
  });

  test('names a subscriber that asks for what is not offered', async (context) => {
    const other = new Peer();
    context.after(() => other.kill());
    other.tell(`reader late rt/omni/spatial/servo_cf ${ddsType('geometry_msgs/WrenchStamped')} reliable kept`);
    await palpate.says('a subscriber of rt/omni/spatial/servo_cf has an incompatible quality of service (durability)');
  });
});

test('a driver that does not listen is told, and feels no step once it does, in contact', async (context) => {
  const { path } = makeWall(makeFolder());
  const palpate = new Program(process.env.PALPATE, 'run', path, '--no-gateway', '--no-index-file', '--tool', '0.02,0.02,0.02',
    '--device', 'ros2:/deaf,force_max=8,rate=20');
  context.after(() => palpate.end());
  const driver = new Driver('/deaf', 'reliable', true, undefined, '/misspelt');
  context.after(() => driver.kill());
  driver.tell(`to ${FREE}`);
  await palpate.says('nothing subscribes to spatial/servo_cf or body/servo_cf');
  driver.tell(`to ${PRESSED}`);
  await wait(1000);
  driver.tell(`reader heard rt/deaf/spatial/servo_cf ${ddsType('geometry_msgs/WrenchStamped')} reliable`);
  driver.reader = 'heard';
  const newest = () => driver.newest('heard', 'geometry_msgs/WrenchStamped');
  await eventually(newest, 'a wrench');
  for (let k = 0; k < 20; k += 1) {
    assert.equal((await newest()).wrench.force.z, 0);
    await wait(50);
  }
  await driver.lean();
  assert.equal(palpate.said.split('nothing subscribes').length, 2, palpate.said);
});

test('bad settings are one line', () => {
  const refuse = (words, device, env = {}) => {
    try {
      execFileSync(process.env.PALPATE, ['run', '--no-gateway', '--device', device, '--seconds', '1'],
        { env: { ...environment, ...env }, stdio: ['ignore', 'pipe', 'pipe'] });
    } catch ({ status, stderr }) {
      assert.equal(status, 1);
      assert.ok(stderr.toString().includes(words), stderr.toString());
      assert.equal(stderr.toString().split('\n').length, 2, stderr.toString());
      return;
    }
    assert.fail(`${device} is taken`);
  };
  refuse("needs the prefix of the device's topics, such as ros2:/omni", 'ros2:omni');
  refuse("there is no option 'weight'", 'ros2:/omni,weight=3');
  refuse("ROS_DOMAIN_ID: 'many' is not a whole number from 0 to 232", 'ros2:/omni', { ROS_DOMAIN_ID: 'many' });
});
