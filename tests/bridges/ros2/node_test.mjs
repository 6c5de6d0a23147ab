// The node palpate_ros2: what it publishes, read by another implementation over another DDS, and its services and parameters.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, readFileSync } from 'node:fs';
import { basename, dirname, join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { ddsType, decode, encode } from './messages.mjs';
import { Driver, FREE, PRESSED, Program, eventually, makeFolder, makeWall, poseMessage, triggerRequest, wait } from './program.mjs';

const kMarkers = 'visualization_msgs/MarkerArray';
const kAdd = 0;
const kDelete = 2;
const kDecimation = 7;
const kLow = -0.1; // height of the other wall. Unit: [m]
const near = (a, b, by = 1e-6) => assert.ok(Math.abs(a - b) <= by, `${a} is not ${b}`);
const isUnit = (q) => near(Math.hypot(q.x, q.y, q.z, q.w), 1, 1e-9);

/** As rmw_cyclonedds_cpp puts who asks, and the number of the question, before what is asked. */
const kSetBool = 'uint64 client\nint64 number\nbool data';
/** Of a recording: name to text. */
function rowsOf(path) {
  const [head, ...lines] = readFileSync(path, 'utf8').split('\n').filter((line) => line && !line.startsWith('#'));
  const names = head.split(',');
  return lines.map((line) => Object.fromEntries(line.split(',').map((text, k) => [names[k], text])));
}

const kDone = 'uint64 client\nint64 number\nbool success\nstring message';

describe('the node', () => {
  let node;
  let driver;
  let wall;
  let low;
  let runs;
  let asked = 0;

  before(async () => {
    const folder = makeFolder();
    wall = makeWall(folder);
    runs = join(folder, 'runs');
    const scenes = join(folder, 'scenes');
    mkdirSync(runs);
    mkdirSync(scenes);
    low = makeWall(scenes, kLow, 'low.ply');
    node = new Program(process.env.PALPATE_ROS2, '--ros-args', '-p', `scene:=${wall.path}`, '-p', 'no_index_file:=true',
      '-p', 'tool:=[0.02, 0.02, 0.02]', '-p', 'device:=/omni,force_max=8,rate=20', '-p', `cloud_decimation:=${kDecimation}`,
      '-p', 'device_frame:=base', '-p', `scenes:=${scenes}`, '-p', `recordings:=${runs}`, '-r', '__ns:=/left', '-r', '/omni/measured_cp:=/arm/measured_cp',
      '-r', '/omni/spatial/servo_cf:=/arm/spatial/servo_cf', '-r', 'palpate/tool:=/shown');
    driver = new Driver('/omni', 'reliable', false);
    driver.tell(`writer moved rt/arm/measured_cp ${ddsType('geometry_msgs/PoseStamped')} reliable`);
    driver.tell(`reader force rt/arm/spatial/servo_cf ${ddsType('geometry_msgs/WrenchStamped')} reliable`);
    driver.tell(`reader contacts rt/left/palpate/contacts ${ddsType(kMarkers)} reliable`);
    driver.tell(`reader tool rt/shown ${ddsType(kMarkers)} reliable`);
    driver.tell(`reader tf rt/tf ${ddsType('tf2_msgs/TFMessage')} reliable`);
    driver.tell(`reader diagnostics rt/diagnostics ${ddsType('diagnostic_msgs/DiagnosticArray')} reliable`);
    driver.tell(`writer set rt/left/palpate/set_parameters ${ddsType('std_msgs/String')} reliable`);
    driver.tell(`writer open rt/left/palpate/open_scene ${ddsType('std_msgs/String')} reliable`);
    for (const [name, type] of [['emergency_stop', 'Trigger'], ['resume', 'Trigger'], ['get_parameters', 'Trigger'], ['config', 'Trigger'], ['pause', 'SetBool'], ['clutch', 'SetBool'],
      ['record', 'SetBool'], ['list_scenes', 'Trigger']]) {
      driver.tell(`writer ${name} rq/left/palpate/${name}Request std_srvs::srv::dds_::${type}_Request_ reliable`);
      driver.tell(`reader ${name}_done rr/left/palpate/${name}Reply std_srvs::srv::dds_::${type}_Response_ reliable`);
    }
    driver.walks('moved');
    driver.reader = 'force';
    await eventually(async () => await driver.number('matched clutch') > 0 && await driver.number('matched clutch_done') > 0
      && await driver.number('matched record') > 0 && await driver.number('matched record_done') > 0
      && await driver.number('matched list_scenes') > 0 && await driver.number('matched list_scenes_done') > 0, 'services');
  });
  after(async () => {
    await driver.kill();
    assert.equal(await node.end(), 0, node.said);
  });

  async function status(name) {
    const array = await driver.newest('diagnostics', 'diagnostic_msgs/DiagnosticArray');
    const found = array?.status.find((one) => one.name === name);
    return found && { level: Number(found.level), message: found.message, ...Object.fromEntries(found.values.map((v) => [v.key, v.value])) };
  }
  async function statusIs(name, level, words = '') {
    let last;
    await eventually(async () => {
      last = await status(name);
      return last?.level === level && last.message.includes(words);
    }, () => `${level} ${words}, but ${JSON.stringify(last)}`);
    return last;
  }
  async function call(name, data, success = true) {
    asked += 1;
    const head = { client: 0x1234567890abcdefn, number: BigInt(asked) };
    driver.tell(`clear ${name}_done`);
    driver.tell(`send ${name} ${data === undefined ? triggerRequest(head.client, head.number) : encode(kSetBool, { ...head, data })}`);
    let answer;
    await eventually(async () => {
      const hex = await driver.ask(`newest ${name}_done`);
      answer = hex === '-' ? undefined : decode(kDone, hex);
      return answer;
    }, `an answer of ${name}`);
    const { message, ...rest } = answer;
    assert.deepEqual(rest, { ...head, success });
    return message;
  }

  test('shows contacts that are there, and deletes what is gone', async () => {
    await driver.lean();
    await wait(200);
    const { markers } = await driver.newest('contacts', kMarkers);
    const added = markers.filter((m) => m.action === kAdd);
    assert.ok(added.length > 0);
    for (const m of added) {
      assert.equal(m.header.frame_id, 'world');
      near(m.header.stamp.sec, Date.now() / 1000, 5);
      isUnit(m.pose.orientation);
      assert.deepEqual(m.lifetime, { sec: 0, nanosec: 0 });
      assert.deepEqual([m.colors.length, m.uv_coordinates.length, m.texture.data.length, m.mesh_file.data.length], [0, 0, 0, 0]);
      assert.deepEqual([m.text, m.mesh_resource, m.texture_resource, m.mesh_file.filename], ['', '', '', '']);
      const row = wall.rows[m.id];
      if (m.ns === 'contacts') {
        assert.equal(m.type, 2);
        [m.pose.position.x, m.pose.position.y, m.pose.position.z].forEach((at, k) => near(at, row[k]));
        const sizes = [m.scale.x, m.scale.y, m.scale.z].sort((a, b) => a - b);
        [...row.slice(7, 10)].sort((a, b) => a - b).forEach((log, k) => near(sizes[k], 2 * Math.exp(log)));
        assert.ok(added.some((other) => other.ns === 'normals' && other.id === m.id));
      } else {
        assert.equal(m.ns, 'normals');
        assert.equal(m.type, 0);
        assert.equal(m.points.length, 2);
        assert.ok(m.points[1].z >= m.points[0].z);
      }
    }
    const tool = await driver.newest('tool', kMarkers);
    assert.deepEqual(tool.markers.map((m) => [m.ns, m.id, m.type]), [['tool', 0, 2]]);
    near(tool.markers[0].scale.x, 0.04);
    driver.tell(`to ${FREE}`);
    await eventually(async () => (await driver.newest('contacts', kMarkers)).markers.some((m) => m.action === kDelete), 'deletions');
  });

  test('poses pass through real-time threads only', (context) => {
    const threads = node.threads();
    const [policy, priority] = threads['palpate-servo'].split(' ');
    if (policy !== '1') {
      context.skip('real-time priority is not permitted here');
      return;
    }
    const below = `1 ${priority - 10}`;
    for (const name of ['palpate-ros2', 'recv']) assert.equal(threads[name], below, name); // `recv` is Cyclone's
    assert.equal(threads['palpate-sender'], '0 0', 'wrenches take no time from a driver');
  });
  test('tells frames', async () => {
    await driver.lean();
    await wait(500);
    const { transforms } = await driver.newest('tf', 'tf2_msgs/TFMessage');
    const frames = new Map(transforms.map((t) => [t.child_frame_id, t]));
    assert.deepEqual([...frames.keys()].sort(), ['base', 'palpate/proxy', 'palpate/scene', 'palpate/tool']);
    for (const t of frames.values()) {
      assert.equal(t.header.frame_id, 'world');
      isUnit(t.transform.rotation);
    }
    near(frames.get('palpate/tool').transform.translation.z, PRESSED, 1e-3);
    assert.ok(frames.get('palpate/proxy').transform.translation.z > PRESSED + 1e-4);
  });

  test('keeps the centres for who comes later', async () => {
    driver.tell(`reader centers rt/left/palpate/centers ${ddsType('sensor_msgs/PointCloud2')} reliable kept`);
    await eventually(async () => await driver.number('count centers') > 0, 'centres');
    const cloud = await driver.newest('centers', 'sensor_msgs/PointCloud2');
    const rows = wall.rows.filter((_, k) => k % kDecimation === 0);
    assert.deepEqual([cloud.header.frame_id, cloud.height, cloud.width, cloud.point_step, cloud.row_step, cloud.is_dense, cloud.is_bigendian],
      ['world', 1, rows.length, 12, 12 * rows.length, true, false]);
    assert.deepEqual(cloud.fields.map((f) => [f.name, f.offset, f.datatype, f.count]), [['x', 0, 7, 1], ['y', 4, 7, 1], ['z', 8, 7, 1]]);
    const view = new DataView(cloud.data.buffer, cloud.data.byteOffset, cloud.data.byteLength);
    const points = rows.map((_, k) => [0, 4, 8].map((at) => view.getFloat32(12 * k + at, true)));
    points.forEach(([x, y, z]) => { near(z, 0); assert.ok(Math.max(Math.abs(x), Math.abs(y)) <= 0.1 + 1e-6); });
  });

  for (const [name, stop, level, again] of [
    ['emergency_stop', undefined, 2, () => call('resume')],
    ['pause', true, 2, () => call('pause', false)],
    ['clutch', true, 1, () => call('clutch', false)],
  ]) {
    test(`the service ${name} ends the force until it is taken back`, async () => {
      await driver.lean();
      await call(name, stop);
      await driver.noForce();
      const { message, fault, advice } = await statusIs('palpate: servo', level);
      assert.equal(fault, message);
      assert.ok(advice);
      await again();
      await driver.lean();
      await statusIs('palpate: servo', 0);
    });
  }

  test('settings are read and changed', async () => {
    const stiffness = async () => JSON.parse(await call('get_parameters')).stiffness;
    const set = (data) => driver.tell(`send set ${encode('std_msgs/String', { data })}`);
    assert.equal(await stiffness(), 500);
    await eventually(async () => await driver.number('matched set') > 0, 'a listener');
    set('{"stiffness": 300}');
    await eventually(async () => await stiffness() === 300, 'a change');
    assert.ok((await call('config')).includes('stiffness = 300'));
    set('{"device": {}}');
    await node.says("set_parameters: parameters has no 'device'");
    set('{"stiffness": 500}');
    await eventually(async () => await stiffness() === 500, 'a change');
  });

  const open = (data) => driver.tell(`send open ${encode('std_msgs/String', { data })}`);

  test('a recording is begun and ended', async () => {
    assert.equal(await call('record', false, false), 'nothing is being recorded');
    const path = await call('record', true);
    assert.equal(dirname(path), runs);
    assert.match(basename(path), /^palpate-\d{4}(-\d\d){5}\.csv$/);
    assert.equal(await call('record', true, false), 'a recording is under way');
    await driver.lean();
    assert.equal((await status('palpate: scene')).recording, path);
    await eventually(async () => await driver.number('matched open') > 0, 'a listener');
    open(low.path);
    await node.says('open_scene: a recording contains one scene only; stop it first');
    await eventually(() => rowsOf(path).length > 100, 'rows, while it is made');
    assert.equal(await call('record', false), path);
    const rows = rowsOf(path);
    assert.ok(Math.max(...rows.map((row) => Number(row.sfz))) > 0.5);
    await wait(200);
    assert.equal(rowsOf(path).length, rows.length);
    const again = join(runs, 'again.csv');
    const replay = spawnSync(process.env.PALPATE, ['replay', '--from', path, '--out', again], { encoding: 'utf8' });
    assert.equal(replay.status, 0, replay.stderr);
    const poses = (all) => all.map((row) => ['t', 'x', 'y', 'z', 'qw', 'qx', 'qy', 'qz'].map((name) => row[name]));
    assert.deepEqual(poses(rowsOf(again)), poses(rows));
  });

  test('another scene is felt', async () => {
    const list = JSON.parse(await call('list_scenes'));
    const { id } = list.find(({ name }) => name === 'low.ply');
    await driver.lean();
    open(id);
    await node.says('low.ply is active');
    assert.equal(JSON.parse(await call('get_parameters')).scene.path, low.path);
    await driver.noForce();
    await eventually(async () => (await status('palpate: scene')).scene === low.path, 'its name');
    open('/nowhere/at/all.ply');
    await node.says('open_scene: /nowhere/at/all.ply');
    assert.equal(JSON.parse(await call('get_parameters')).scene.path, low.path);
    open(wall.path);
    await node.says('wall.ply is active');
    await driver.lean();
  });

  for (const [words, said, spoil, mend] of [
    ['not finite', 'no force until valid poses arrive', () => driver.bad(poseMessage('base', NaN))],
    ['not of unit norm', 'no force until valid poses arrive', () => driver.bad(poseMessage('base', 0.016, 2))],
    ['wrong frame_id', "in the frame 'else', not 'base'", () => driver.bad(poseMessage('else', 0.016))],
    ['poses are late', 'late, repeated or out of order', () => driver.tell('late 0.5'), () => driver.tell('late 0')],
    ['no poses received', '', () => driver.tell('mute 1'), () => driver.tell('mute 0')],
  ]) {
    test(`says in diagnostics: ${words}`, async () => {
      await driver.lean();
      await statusIs('palpate: device', 0);
      spoil();
      await driver.noForce();
      const { notice, dropped } = await statusIs('palpate: device', 2, words);
      assert.ok(notice.includes(said), notice);
      assert.ok(said === '' || Number(dropped) > 0);
      (mend ?? (() => driver.good()))();
      await statusIs('palpate: device', 0);
      await driver.lean();
    });
  }

  test('says in diagnostics: stamps in the future, and a second publisher', async (context) => {
    await driver.lean();
    driver.tell('late -5');
    await eventually(async () => (await status('palpate: device')).notice.includes('stamps in the future'), 'a notice');
    driver.tell('late 0');
    await driver.lean();
    const other = new Driver('/arm');
    context.after(() => other.kill());
    await eventually(async () => (await status('palpate: device')).notice.includes('controls the device until it is silent for 1 s'), 'a notice');
    await statusIs('palpate: device', 1, 'poses are dropped');
  });
});

test('help is printed', async () => {
  for (const argument of ['--help', '-h']) {
    const node = new Program(process.env.PALPATE_ROS2, argument);
    const [code] = await node.ended;
    assert.equal(code, 0, node.said);
    assert.ok(node.said.includes('Usage: palpate_ros2 [--ros-args [-p PARAMETER:=VALUE]...') && node.said.includes('left.stiffness'), node.said);
  }
});

test('bad arguments are one line', async () => {
  for (const [words, ...args] of [
    ["there is no parameter 'stifness'", '-p', 'stifness:=300'],
    ["parameter 'stiffness'", '-p', 'stiffness:=much'],
    ["'scene' is not NAME:=VALUE", '-p', 'scene'],
    ["'1bad:=x y' are not names of topics", '-r', '1bad:=x y'],
    ["'left' is not a valid namespace", '-r', '__ns:=left'],
    ["'--params-file' is not an argument", '--params-file', 'x.yaml'],
    ["needs the prefix of the device's topics, such as ros2:/omni", '-p', 'device:=omni'],
  ]) {
    const node = new Program(process.env.PALPATE_ROS2, '--ros-args', ...args);
    const [code] = await node.ended;
    assert.equal(code, 1, node.said);
    assert.ok(node.said.startsWith('palpate_ros2: ') && node.said.includes(words), node.said);
    assert.equal(node.said.split('\n').length, 2, node.said);
  }
});
