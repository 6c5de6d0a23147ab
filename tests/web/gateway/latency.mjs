// How long it takes from a pose that a client publishes to the wrench that answers it: rows of a table.
// usage: node latency.mjs [ANSWERS]

import { drive, quantile } from './drive.mjs';
import { connect, makeFolder, start } from './palpate.mjs';

const answers = Number(process.argv[2] ?? 6000);
const place = (t) => [0.001 * Math.sin(10 * t), 0, 0.165]; // on the sphere, a ball of 20 mm

const { folder, remove } = makeFolder();
const program = await start(folder, '--device', 'client', '--tool', '0.02,0.02,0.02');
const ros = await connect(program.url);
console.log('| wrench as | answers | p50 ms | p90 | p99 |\n|---|---|---|---|---|');
for (const [name, compression] of [['JSON', 'none'], ['CBOR', 'cbor']]) {
  const times = [];
  await drive(ros, place, () => times.length >= answers, (force, took) => times.push(took), compression);
  const shares = [0.5, 0.9, 0.99].map((share) => quantile(times, share).toFixed(2));
  console.log(`| ${name} | ${times.length} | ${shares.join(' | ')} |`);
}
ros.close();
await program.stop();
remove();
