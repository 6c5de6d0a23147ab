// What clients do to the servo loop: 64 that are subscribed to everything, of which 8 never read and 4 send garbage,
// and none, by turns: rows of a table.
// usage: node load.mjs [SECONDS [TURNS]]

import { readFileSync } from 'node:fs';
import WebSocket from 'ws';
import { makeFolder, start } from './palpate.mjs';

const [seconds, turns] = [Number(process.argv[2] ?? 60), Number(process.argv[3] ?? 2)];
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

async function turn(folder, count) {
  const program = await start(folder);
  const all = [...Array(count).keys()].map((k) => new Client(program.url, k));
  await wait(500 * seconds);
  const half = resident(program.pid);
  await wait(500 * seconds);
  const end = resident(program.pid);
  const { tick_us: tick, ticks, overruns } = await program.stop();
  all.forEach((client) => client.end());
  const messages = all.reduce((sum, client) => sum + client.messages, 0);
  console.log(`| ${count} | ${tick.p50.toFixed(1)} | ${tick.p99.toFixed(1)} | ${overruns} of ${ticks} | ${messages} | ${half.toFixed(0)} | ${end.toFixed(0)} |`);
}

console.log('| clients | tick p50 us | p99 | overruns | messages | resident MB at half time | at the end |\n|---|---|---|---|---|---|---|');
const { folder, remove } = makeFolder();
for (let k = 0; k < turns; k += 1) {
  await turn(folder, 0);
  await turn(folder, clients.all);
}
remove();
