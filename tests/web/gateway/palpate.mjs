// Starts the program, and talks to it.

import { spawn, execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { Ros, Topic } from 'roslib';

const program = process.env.PALPATE;
const patience = 60_000; // ms; instrumented, on a small machine

/// What a command prints in a folder.
export const run = (folder, ...args) => execFileSync(program, args, { cwd: folder, encoding: 'utf8' });

/// A folder with a sphere of 0.15 m around the origin, as sphere.ply.
export function makeFolder() {
  if (!program) throw new Error('PALPATE must name the program');
  const folder = mkdtempSync(path.join(os.tmpdir(), 'palpate-gateway-'));
  run(folder, 'make-scene', 'sphere', '--out', 'sphere.ply', '-q');
  return { folder, remove: () => rmSync(folder, { recursive: true, force: true }) };
}

/// `palpate run sphere.ply` on a free port, once it serves. `stop` ends it and gives its summary.
export async function start(folder, ...more) {
  const child = spawn(program, ['run', 'sphere.ply', '--port', '0', '--json', ...more],
    { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'] });
  let out = '';
  let said = '';
  child.stdout.on('data', (bytes) => { out += bytes; });
  const exit = new Promise((done) => { child.on('exit', done); });
  const url = await new Promise((found, failed) => {
    child.stderr.on('data', (bytes) => {
      said += bytes;
      const match = /https?:\/\/127\.0\.0\.1:\d+\//.exec(said);
      if (match) found(match[0]);
    });
    exit.then(() => failed(new Error(said)));
  });
  const stop = async () => {
    child.kill('SIGTERM');
    await exit;
    return JSON.parse(out);
  };
  return { url, pid: child.pid, stop, kill: () => child.kill('SIGKILL') };
}

/// A connected client.
export async function connect(url) {
  const ros = new Ros();
  await ros.connect(url.replace('http', 'ws'));
  return ros;
}

/// The first message of a topic that `fits`.
export function first(ros, name, messageType, fits = () => true, options = {}) {
  return new Promise((found, failed) => {
    const topic = new Topic({ ros, name, messageType, ...options });
    const timer = setTimeout(() => failed(new Error(`${name}: nothing that fits came`)), patience);
    topic.subscribe((message) => {
      if (!fits(message)) return;
      clearTimeout(timer);
      topic.unsubscribe();
      found(message);
    });
  });
}

/// The next status that the server tells the client. roslib gives it out under the id that it answers.
export function nextStatus(ros) {
  return new Promise((told, failed) => {
    const timer = setTimeout(() => failed(new Error('no status came')), patience);
    const { emit } = ros;
    ros.emit = (event, ...values) => {
      if (String(event).startsWith('status')) {
        ros.emit = emit;
        clearTimeout(timer);
        told(values[0]);
      }
      return emit.call(ros, event, ...values);
    };
  });
}

/// What palpate's diagnostics say, as an object.
export const valuesOf = (message) =>
  Object.fromEntries(message.status[0].values.map(({ key, value }) => [key, value]));
