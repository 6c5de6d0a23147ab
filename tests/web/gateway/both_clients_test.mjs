// The reference clients in C++ and JavaScript make the same wrenches of the same sequences of wrenches, local models, poses and
// times, as hostile as they come; and what both make is fit for motors.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { describe, test } from 'node:test';
import { pathToFileURL } from 'node:url';

const { LocalRenderer, WrenchGovernor, isGood } = await import(pathToFileURL(process.env.PALPATE_CLIENT));

// Roundings differ: std::hypot is not Math.hypot. A root of what is left of an energy makes 1e-9 N of a rounding of 1e-16 J.
const tolerance = 1e-7;

/// As the C++ program that PALPATE_GOVERNOR_TRACE names does, line by line.
function follow(lines) {
  let governor = null;
  let renderer = null;
  let model = { planes: [], position: [0, 0, 0], stiffness: 0, damping: 0, friction: 0, share: 0 };
  let asked = [0, 0, 0];
  const results = [];
  const print = ({ force, torque }) => results.push([...force, ...torque]);
  const calls = {
    limits(forceMax, torqueMax, damping) {
      governor = new WrenchGovernor({ forceMax, torqueMax, damping });
      renderer = new LocalRenderer({ forceMax, damping });
      model = { planes: [], position: [0, 0, 0], stiffness: 0, damping: 0, friction: 0, share: 0 };
      asked = [0, 0, 0];
    },
    take(...x) { governor.take({ force: x.slice(0, 3), torque: x.slice(3, 6) }, x[6], x[7]); },
    model(measuredAt, t, stiffness, damping, friction, share, ...rest) {
      const planes = [];
      for (let k = 3; k < rest.length; k += 6) planes.push({ point: rest.slice(k, k + 3), normal: rest.slice(k + 3, k + 6) });
      const next = { position: rest.slice(0, 3), planes, stiffness, damping, friction, share };
      governor.takeModel(next, measuredAt, t);
      if (isGood(next)) model = next;
    },
    fail() { governor.fail(); },
    show(now) { print(governor.show(now)); },
    show_at(x, y, z, now) { print(governor.showAt([x, y, z], now)); },
    ask(x, y, z, now) {
      asked = renderer.ask(model, [x, y, z], now);
      results.push([...asked, renderer.most, renderer.pressed, renderer.energy]);
    },
    shown(share) { renderer.show(asked.map((f) => share * f)); },
  };
  for (const [what, ...numbers] of lines) calls[what](...numbers);
  return results;
}

function followInCpp(lines) {
  const input = lines.map((words) => words.join(' ')).join('\n');
  const { status, stdout } = spawnSync(process.env.PALPATE_GOVERNOR_TRACE, { input, encoding: 'utf8', maxBuffer: 1 << 30 });
  assert.equal(status, 0);
  return stdout.trim().split('\n').map((line) => line.trim().split(' ')
    .map((x) => (/nan/.test(x) ? NaN : Number(x.replace('inf', 'Infinity')))));
}

/// mulberry32
function randomOf(seed) {
  let state = seed;
  const uniform = (from = 0, to = 1) => {
    state = (state + 0x6d2b79f5) | 0;
    let x = Math.imul(state ^ (state >>> 15), state | 1);
    x = (x + Math.imul(x ^ (x >>> 7), x | 61)) ^ x;
    return from + (to - from) * (((x ^ (x >>> 14)) >>> 0) / 2 ** 32);
  };
  const chance = (p) => uniform() < p;
  const pick = (...of) => of[Math.floor(uniform(0, of.length))];
  const vector = (size) => [uniform(-size, size), uniform(-size, size), uniform(-size, size)];
  const unit = () => {
    const v = vector(1);
    return v.map((x) => x / Math.hypot(...v));
  };
  return { uniform, chance, pick, vector, unit, decade: (from, to) => 10 ** uniform(from, to) };
}

const odd = [NaN, Infinity, -Infinity, 1e308, -1e308, 5e-324, -0, 2e6, -1];

/// A session of a hand over a floor, with everything that may come in between. `trouble` is how often.
function session(seed, ticks, trouble) {
  const random = randomOf(seed);
  const { uniform, chance, pick, vector, unit, decade } = random;
  const limits = [pick(12, 3.3, 1e-9, 1e300, 8), pick(0, 0.5), pick(2, 1, 0.05, 0, 40, 2)];
  if (trouble === 0) limits.splice(0, 3, 12, 0.5, 2);
  const lines = [['limits', ...limits]];
  let now = decade(-3, 5);
  let place = [0, 0, 0.002];
  let goal = [0, 0, -0.002];
  let delay = 0.02; // s
  let silentUntil = 0;
  let normal = [0, 0, 1];
  let surface = { stiffness: 500, damping: 1, friction: 0.3, share: 1, planes: [] };
  for (let k = 0; k < ticks; k += 1) {
    now += 1e-3;
    if (chance(0.01)) goal = vector(0.004);
    const speed = decade(-6, -3.5); // m a tick
    place = place.map((x, i) => x + Math.max(-speed, Math.min(speed, goal[i] - x)));

    if (chance(0.02)) { // another surface
      normal = chance(0.5) ? [0, 0, 1] : unit();
      surface = {
        stiffness: decade(1, 4), damping: uniform(0, 5), friction: pick(0, 0.2, uniform(0, 3)), share: pick(0, 1, 1, 1, uniform()), planes: [],
      };
      for (let count = pick(0, 1, 1, 1, 2, 3, 4); count > 0; count -= 1)
        surface.planes.push([...place.map((x) => x + uniform(-1e-3, 1e-3)), ...(count === 1 ? normal : unit())]);
    }
    const { stiffness, damping, friction, share, planes } = surface;
    let model = [now - delay, now, stiffness, damping, friction, share, ...place, ...planes.flat()];
    let wrench = [...vector(chance(0.5) ? 0.3 : 20), ...vector(0.02), now - delay, now];
    let shownAt = place;

    const isTrouble = () => chance(trouble);
    if (isTrouble()) delay = pick(0, 0.005, 0.02, 0.045, 0.049, 0.05, 0.08, 0.099, 0.1, 0.2, -0.01, NaN);
    if (isTrouble()) silentUntil = now + pick(0.01, 0.044, 0.045, 0.046, 0.05, 0.3);
    if (isTrouble()) model[pick(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14)] = pick(...odd);
    if (isTrouble()) wrench[Math.floor(uniform(0, 8))] = pick(...odd);
    if (isTrouble()) model = [...model.slice(0, 9), ...Array.from({ length: pick(4, 5, 9) }, () => [...place, ...unit()]).flat()];
    if (isTrouble()) model = [...model.slice(0, 9), ...place, 0, 0, 0]; // no normal
    if (isTrouble()) model = [...model.slice(0, 9), ...place, 0, 0, pick(1.0009, 0.9991, 1.0011, 1e-320)];
    if (isTrouble()) model = [...model.slice(0, 9), ...place, 0, 0, 1, ...place, 0, 0, -1]; // nowhere to be
    if (isTrouble()) model = [...model.slice(0, 9), ...vector(pick(1e-320, 1, 1e6, 1e308)), ...unit()];
    if (isTrouble()) model[2] = 0; // no local model
    if (isTrouble()) model.splice(6, 3, ...place.map((x) => x + pick(0, 0.0057, 0.0058, 0.006, 1))); // of another place
    if (isTrouble()) shownAt = pick(place.map((x, i) => (i === 1 ? NaN : x)), [NaN, 0, 0], [0, Infinity, 0], [1e308, 1e308, 1e308], place.map((x) => x + pick(0.028, 0.03)), [5e-324, 0, 0]);
    if (isTrouble()) now += pick(-1e-3, -1e-3, -0.5e-3, 0.004, 0.0499, 0.05, 0.0501, 1, 1e6); // stands still, or jumps
    if (isTrouble()) { // late, on the way out: a debt
      now += 0.02;
      shownAt = place.map((x, i) => x + 0.005 * normal[i]);
    }
    if (isTrouble()) lines.push(['fail']);
    if (now >= silentUntil) {
      if (chance(0.9)) lines.push(['take', ...wrench]);
      if (chance(0.9)) lines.push(['model', ...model]);
    }
    if (chance(trouble / 2)) lines.push(['show', now]);
    else lines.push(['show_at', ...shownAt, now]);
    if (limits[2] > 0) lines.push(['ask', ...shownAt, now], ['shown', chance(0.9) ? 1 : uniform()]);
  }
  return { lines, limits };
}

/// Both, held against each other; what share of the wrenches was a force of a local model, or of a wrench.
function compare(seed, ticks, trouble) {
  const { lines, limits: [forceMax, torqueMax] } = session(seed, ticks, trouble);
  const results = follow(lines);
  const expected = followInCpp(lines);
  assert.equal(results.length, expected.length);
  const asking = lines.filter(([what]) => what.startsWith('show_') || what === 'show' || what === 'ask');
  let worst = 0;
  let felt = 0;
  results.forEach((result, k) => {
    const where = `seed ${seed}, ${asking[k].join(' ')}: ${result} in JavaScript, ${expected[k]} in C++`;
    result.forEach((x, i) => {
      const error = Object.is(x, expected[k][i]) || x === expected[k][i] ? 0 : Math.abs(x - expected[k][i]) / (1 + Math.abs(x));
      assert.ok(error <= tolerance, where);
      worst = Math.max(worst, error);
    });
    if (asking[k][0] === 'ask') return;
    assert.ok(result.every(Number.isFinite), where);
    assert.ok(Math.hypot(...result.slice(0, 3)) <= forceMax * (1 + 1e-12), where);
    assert.ok(Math.hypot(...result.slice(3)) <= torqueMax * (1 + 1e-12), where);
    if (result.slice(0, 3).some((x) => x !== 0)) felt += 1;
  });
  return { worst, felt, of: asking.filter(([what]) => what !== 'ask').length };
}

describe('both reference clients', () => {
  for (const [name, trouble, seeds] of [['a hand at work', 0, 8], ['now and then trouble', 0.002, 16], ['hardly anything but trouble', 0.05, 16]]) {
    test(`make the same of ${name}`, (t) => {
      const all = Array.from({ length: seeds }, (_, seed) => compare(1 + seed, 3000, trouble));
      const felt = all.reduce((n, one) => n + one.felt, 0) / all.reduce((n, one) => n + one.of, 0);
      t.diagnostic(`worst difference ${Math.max(...all.map(({ worst }) => worst))}; a force in ${(100 * felt).toFixed(0)} %`);
      assert.ok(felt > (trouble > 0.01 ? 0.02 : 0.1), `a force in ${felt}`);
    });
  }
});
