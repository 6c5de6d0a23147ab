// How long it takes from a pose that a client publishes to the wrench that answers it: rows of a table. The last row is
// of a server of this process's kind that only parses the pose and sends a wrench of zeros: what the client and the
// machine take of it.
// usage: node latency.mjs [ANSWERS]

import { fork } from 'node:child_process';
import { once } from 'node:events';
import { fileURLToPath } from 'node:url';
import { WebSocketServer } from 'ws';
import { drive, quantile } from './drive.mjs';
import { connect, makeFolder, start } from './palpate.mjs';

const self = fileURLToPath(import.meta.url);
const place = (t) => [0.001 * Math.sin(10 * t), 0, 0.165]; // on the sphere, a ball of 20 mm

function echo() {
  const zero = { x: 0, y: 0, z: 0 };
  const server = new WebSocketServer({ host: '127.0.0.1', port: 0 }, () => process.send(server.address().port));
  server.on('connection', (socket) => {
    socket.on('message', (text) => {
      const { op, msg } = JSON.parse(text);
      if (op !== 'publish') return;
      const wrench = { header: msg.header, wrench: { force: zero, torque: zero } };
      socket.send(JSON.stringify({ op, topic: '/palpate/client/servo_cf', msg: wrench }));
    });
  });
}

async function measure(answers) {
  const { folder, remove } = makeFolder();
  const program = await start(folder, '--device', 'client', '--tool', '0.02,0.02,0.02');
  const other = fork(self, ['echo']);
  const [port] = await once(other, 'message');
  const [ros, plain] = [await connect(program.url), await connect(`http://127.0.0.1:${port}/`)];
  const rows = [['JSON', ros, 'none'], ['CBOR', ros, 'cbor'], ['an echo, JSON', plain, 'none']]
    .map(([name, server, compression]) => ({ name, server, compression, times: [] }));
  const turns = 6; // by turns: a machine that gets slower tells on all
  for (let turn = 1; turn <= turns; turn += 1) {
    for (const { server, compression, times } of rows)
      await drive(server, place, () => times.length >= (answers * turn) / turns, (force, took) => times.push(took), compression);
  }
  [ros, plain].forEach((server) => server.close());
  other.kill();
  await program.stop();
  remove();
  console.log('| wrench as | answers | p50 ms | p90 | p99 |\n|---|---|---|---|---|');
  for (const { name, times } of rows) {
    const shares = [0.5, 0.9, 0.99].map((share) => quantile(times, share).toFixed(2));
    console.log(`| ${name} | ${times.length} | ${shares.join(' | ')} |`);
  }
}

if (process.argv[2] === 'echo') echo();
else await measure(Number(process.argv[2] ?? 12000));
