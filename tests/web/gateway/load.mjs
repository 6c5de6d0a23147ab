// What clients do to the servo loop: 64 that are subscribed to everything, of which 8 never read and 4 send garbage,
// and none, by turns: rows of a table, medians of the turns.
// usage: node load.mjs [SECONDS [PAIRS]]

import { readFileSync } from 'node:fs';
import WebSocket from 'ws';
import { quantile } from './drive.mjs';
import { makeFolder, start } from './palpate.mjs';

const [seconds, pairs] = [Number(process.argv[2] ?? 60), Number(process.argv[3] ?? 5)];
const clients = { all: 64, neverRead: 8, sendGarbage: 4 };
const topics = ['measured_cp', 'measured_cv', 'spatial/servo_cf', 'body/servo_cf', 'proxy_cp', 'contacts', 'tool',
  'diagnostics', 'parameters', 'client/servo_cf'];
const garbageEvery = 10; // ms
const garbage = [...Array(10).keys()].map((k) => `{"op":${Math.random()}${'}'.repeat(k)}`);

class Client {
  messages = 0;

  constructor(url, number) {
    this.socket = new WebSocket(url.replace('http', 'ws'), { perMessageDeflate: false, skipUTF8Validation: true });
    this.socket.on('error', () => {});
    this.socket.on('open', () => this.#begin(number));
  }

  #begin(number) {
    const compression = number % 2 ? 'cbor' : 'none';
    for (const topic of topics)
      this.socket.send(JSON.stringify({ op: 'subscribe', topic: `/palpate/${topic}`, compression }));
    if (number < clients.neverRead) this.socket._socket.pause();
    else this.socket.on('message', () => { this.messages += 1; });
    if (number >= clients.all - clients.sendGarbage)
      this.timer = setInterval(() => garbage.forEach((text) => this.socket.send(text, () => {})), garbageEvery);
  }

  end() {
    clearInterval(this.timer);
    this.socket.terminate();
  }
}

// Unit: [MB].
const resident = (pid) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

const wait = (time) => new Promise((done) => { setTimeout(done, time); });

// What one run of the program was like.
async function turn(folder, count) {
  const program = await start(folder);
  const all = [...Array(count).keys()].map((k) => new Client(program.url, k));
  await wait(500 * seconds);
  const half = resident(program.pid);
  await wait(500 * seconds);
  const end = resident(program.pid);
  const { tick_us: tick, cpu_us: cpu, ticks, overruns } = await program.stop();
  all.forEach((client) => client.end());
  const messages = all.reduce((sum, client) => sum + client.messages, 0);
  return { tick50: tick.p50, tick99: tick.p99, cpu50: cpu.p50, cpu99: cpu.p99, overruns: (100 * overruns) / ticks, messages, half, end };
}

// The median of a figure of some turns, and in which range it was.
function spread(turns, figure, digits) {
  const values = turns.map((turn) => turn[figure]);
  const [middle, least, most] = [quantile(values, 0.5), Math.min(...values), Math.max(...values)];
  return `${middle.toFixed(digits)} (${least.toFixed(digits)}-${most.toFixed(digits)})`;
}

const figures = { tick50: 1, tick99: 1, cpu50: 1, cpu99: 1, overruns: 2, messages: 0, half: 0, end: 0 };
const row = (name, turns) =>
  console.log(`| ${name} | ${Object.entries(figures).map(([figure, digits]) => spread(turns, figure, digits)).join(' | ')} |`);

const { folder, remove } = makeFolder();
const [without, withAll] = [[], []];
for (let k = 0; k < pairs; k += 1) {
  // Each kind is as often the first of its pair as the second: a machine that gets slower tells on both.
  for (const count of k % 2 ? [clients.all, 0] : [0, clients.all])
    (count ? withAll : without).push(await turn(folder, count));
}
remove();
console.log('| clients | tick p50 us | p99 | of it on a processor p50 | p99 | overruns % | messages | resident MB at half time | at the end |\n|---|---|---|---|---|---|---|---|---|');
row('0', without);
row(clients.all, withAll);
// Of two turns that follow each other, so that the machine is the same.
const times = (figure) => quantile(withAll.map((turn, k) => turn[figure] / without[k][figure]), 0.5).toFixed(2);
console.log(`| times as long | ${['tick50', 'tick99', 'cpu50', 'cpu99'].map(times).join(' | ')} | | | | |`);
