// Starts the programs that the tests speak with: a peer on Fast DDS, and Palpate's.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { ddsType, decode, encode } from './messages.mjs';

export const FREE = 0.05; // heights of a ball of 2 cm over the wall. Unit: [m]
export const PRESSED = 0.016;

export const wait = (ms) => new Promise((done) => { setTimeout(done, ms); });

export async function eventually(holds, what = holds, seconds = 20) {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end;) {
    if (await holds()) return;
    await wait(10);
  }
  assert.fail(`never: ${typeof what === 'function' ? what() : what}`);
}

/** A domain that no other test uses while this one runs: each holds the TCP port whose number is that of its domain's discovery. The ports
 * of these domains are not those that the system gives away. */
async function ownDomain() {
  const kFirst = 7400, kEach = 250, kMost = 100;
  for (let i = 0; i < kMost; ++i) {
    const domain = 1 + (process.pid + i) % kMost;
    const lock = createServer().unref().listen(kFirst + kEach * domain, '127.0.0.1');
    try {
      await once(lock, 'listening');
      return String(domain);
    } catch (error) {
      if (error.code !== 'EADDRINUSE') throw error;
    }
  }
  throw new Error('every domain is in use');
}

const kDomain = await ownDomain();
/** On loopback alone, and without multicast, which containers may not have. */
export const environment = {
  ...process.env,
  ROS_DOMAIN_ID: kDomain,
  CYCLONEDDS_URI: '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>'
    + '<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>'
    + '<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>',
};

/** A wall of Gaussians in the plane z = `height`, as a .ply. */
export function makeWall(folder, height = 0, name = 'wall.ply') {
  const names = 'x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3'.split(' ');
  const rows = [];
  for (let i = -10; i <= 10; i += 1)
    for (let j = -10; j <= 10; j += 1) rows.push([0.01 * i, 0.01 * j, height, 0.5, 0, -0.5, 2, -4.8, -4.8, -9, 1, 0, 0, 0]);
  const head = `ply\nformat binary_little_endian 1.0\nelement vertex ${rows.length}\n${names.map((n) => `property float ${n}\n`).join('')}end_header\n`;
  const path = join(folder, name);
  writeFileSync(path, Buffer.concat([Buffer.from(head), Buffer.from(Float32Array.from(rows.flat()).buffer)]));
  return { path, rows };
}

/** A folder that is there until this process ends. */
export function makeFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'palpate-ros2-'));
  process.once('exit', () => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

/** A program of Palpate's. `said` is what it has written so far. */
export class Program {
  constructor(path, ...args) {
    this.said = '';
    this.process = spawn(path, args, { env: environment, stdio: ['ignore', 'pipe', 'pipe'] });
    this.process.stdout.on('data', (text) => { this.said += text; });
    this.process.stderr.on('data', (text) => { this.said += text; });
    this.ended = once(this.process, 'exit');
  }
  says(words, count = 1) {
    return eventually(() => this.said.split(words).length > count, () => `"${words}" in: ${this.said}`);
  }
  /** Scheduling of its threads, {name: 'policy priority'}; policy 1 is SCHED_FIFO. */
  threads() {
    const tasks = `/proc/${this.process.pid}/task`;
    return Object.fromEntries(readdirSync(tasks).map((task) => {
      const [, name, rest] = readFileSync(`${tasks}/${task}/stat`, 'utf8').match(/\((.*)\) (.*)/);
      const fields = rest.split(' '); // from the third on: the 40th is the priority, the 41st the policy
      return [name, `${fields[38]} ${fields[37]}`];
    }));
  }
  async end() {
    this.process.kill('SIGTERM');
    const [code] = await this.ended;
    return code;
  }
}

/** With the `enclave`, a folder with files of DDS Security, or without. */
export class Peer {
  constructor(enclave) {
    this.process = spawn(process.env.PALPATE_ROS2_PEER, [kDomain, ...enclave ? [enclave] : []], { stdio: ['pipe', 'pipe', 'inherit'] });
    this.answers = createInterface({ input: this.process.stdout })[Symbol.asyncIterator]();
    this.ended = once(this.process, 'exit');
  }
  tell(line) { this.process.stdin.write(`${line}\n`); }
  async ask(line) {
    this.tell(line);
    return (await this.answers.next()).value;
  }
  /** The message that a reader got last; undefined: none. */
  async newest(reader, type) {
    const hex = await this.ask(`newest ${reader}`);
    return hex === '-' ? undefined : decode(type, hex);
  }
  async number(line) { return Number(await this.ask(line)); }
  kill() {
    this.process.kill('SIGKILL');
    return this.ended;
  }
}

export const poseMessage = (frame = 'base', z = FREE, w = 1) => ({
  header: { stamp: { sec: 0, nanosec: 0 }, frame_id: frame },
  pose: { position: { x: 0, y: 0, z }, orientation: { x: 0, y: 0, z: 0, w } },
});
/** A request of std_srvs/Trigger, with what identifies it. */
export const triggerRequest = (client, number) => encode('uint64 client\nint64 number\nuint8 structure_needs_at_least_one_member',
  { client, number, structure_needs_at_least_one_member: 0 });
/** Of poses in the frame "base": where their height is, behind the encoding, the header, which ends at a multiple of 8, and x and y. */
const kHeight = 4 + 24 + 16;

/** What drives a device that speaks CRTK: a peer with its topics, which sends poses 1000 times a second. */
export class Driver extends Peer {
  constructor(prefix, reliability = 'reliable', walks = true, enclave = undefined, listens = prefix) {
    super(enclave);
    this.tell(`writer pose rt${prefix}/measured_cp ${ddsType('geometry_msgs/PoseStamped')} ${reliability}`);
    this.tell(`writer echoed rt${prefix}/palpate/echoed ${ddsType('std_msgs/Header')} ${reliability}`);
    this.tell(`reader echo rt${prefix}/palpate/echo ${ddsType('std_msgs/Header')} ${reliability}`);
    this.tell(`reader spatial rt${listens}/spatial/servo_cf ${ddsType('geometry_msgs/WrenchStamped')} ${reliability}`);
    this.tell(`reader body rt${listens}/body/servo_cf ${ddsType('geometry_msgs/WrenchStamped')} ${reliability}`);
    this.tell('answer echo echoed');
    this.good();
    this.reader = 'spatial';
    if (walks) this.walks('pose');
  }
  walks(writer) { this.tell(`walk ${writer} 1000`); }
  async force() { return (await this.newest(this.reader, 'geometry_msgs/WrenchStamped'))?.wrench.force.z ?? 0; }
  /** Through the gate, then against the wall; again where the machine has stood still meanwhile. */
  async lean(least = 0.5) {
    for (let k = 0; k < 10; k += 1) {
      this.tell(`to ${FREE}`);
      await wait(1000);
      this.tell(`to ${PRESSED}`);
      for (let l = 0; l < 100; l += 1) {
        if (await this.force() > least) return;
        await wait(20);
      }
    }
    assert.fail('no force');
  }
  noForce() { return eventually(async () => await this.force() === 0, 'no force'); }
  good() { this.tell(`body ${encode('geometry_msgs/PoseStamped', poseMessage())} 4 ${kHeight}`); }
  /** Whose height stays as it is. */
  bad(message) { this.tell(`body ${encode('geometry_msgs/PoseStamped', message)} 4 -1`); }
}
