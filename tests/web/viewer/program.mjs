// `palpate run` as a process of its own, with a tool that waits above the scene.

import { execFile, spawn } from 'node:child_process';
import { mkdtemp, rm, writeFile } from 'node:fs/promises';
import net from 'node:net';
import os from 'node:os';
import path from 'node:path';
import { promisify } from 'node:util';

const binary = process.env.PALPATE_BINARY;
const startLimit = 30000; // Unit: [ms].
const execute = promisify(execFile);

async function freePort() {
  const server = net.createServer();
  await new Promise((done) => { server.listen(0, '127.0.0.1', done); });
  const { port } = server.address();
  await new Promise((done) => { server.close(done); });
  return port;
}

async function isHealthy(url) {
  try {
    return (await fetch(`${url}healthz`)).ok;
  } catch {
    return false;
  }
}

/// How often the program has been held up, as the page says: on a busy machine it may be. It then takes the force away, which comes
/// back once the tool has been lifted.
export const countHeldUp = () => [...document.querySelectorAll('#messages li')]
  .filter((line) => /no force: (late-tick|stalled|over-energy|late-contacts)/.test(line.textContent)).length;

/// A ball of about 700 Gaussians and a radius of 0.15 m, and programs that feel it.
export class Program {
  static async create() {
    const program = new Program();
    program.folder = await mkdtemp(path.join(os.tmpdir(), 'palpate-viewer-'));
    program.scene = path.join(program.folder, 'ball.ply');
    await execute(binary, ['make-scene', 'sphere', '--out', program.scene, '--spacing', '0.02', '--quiet']);
    program.port = await freePort();
    return program;
  }

  get url() {
    return `http://127.0.0.1:${this.port}/`;
  }

  /// `waitingAt` is where the simulated hand keeps the tool, in the world.
  start(waitingAt, options = [], scene = this.scene) {
    return this.startWith(`t,x,y,z\n0,${waitingAt}\n60,${waitingAt}\n`, [scene, ...options]);
  }

  /// Writes a file into the folder, and gives its path.
  async write(name, bytes) {
    const file = path.join(this.folder, name);
    await writeFile(file, bytes);
    return file;
  }

  /// `trajectory` is the text of the file that the simulated hand follows. Without a scene it is the built-in one.
  async startWith(trajectory, options = []) {
    const file = await this.write('trajectory.csv', trajectory);
    this.process = spawn(binary, ['run', '--port', String(this.port), '--trajectory', file, ...options], { stdio: ['ignore', 'ignore', 'pipe'] });
    let said = '';
    this.process.stderr.on('data', (data) => { said += data; });
    this.ended = new Promise((done) => { this.process.on('exit', done); });
    for (const end = Date.now() + startLimit; !(await isHealthy(this.url));) {
      if (this.process.exitCode !== null || Date.now() > end) throw new Error(`palpate run did not start: ${said}`);
      await new Promise((done) => { setTimeout(done, 50); });
    }
  }

  async stop() {
    this.process.kill('SIGINT');
    await this.ended;
  }

  /// The answer of `palpate query` where the tool is at `position`.
  async query(position, options = []) {
    const { stdout } = await execute(binary, ['query', this.scene, '--pose', position.join(), '--json', '--quiet', ...options]);
    return JSON.parse(stdout);
  }

  /// How many Gaussians `palpate info` keeps.
  async kept(options) {
    const { stdout } = await execute(binary, ['info', this.scene, '--json', '--quiet', ...options]);
    return JSON.parse(stdout).filter.kept;
  }

  remove() {
    return rm(this.folder, { recursive: true, force: true });
  }
}
