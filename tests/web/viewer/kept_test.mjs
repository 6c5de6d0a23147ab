// What can be felt of a scene, what a vibration says, and what is asked of the program: without a browser.

import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Haptics, intensity, slidingSpeed } from './haptics.js';
import { Kept } from './kept.js';
import { Neighbourhood } from './neighbourhood.js';
import { Parameters } from './parameters.js';

const gaussian = (center, { deviations = [0.1, 0.1, 0.1], turn = [0, 0, 0, 1], opacity = 1 } = {}) => [...center, ...deviations, ...turn, opacity];

// As the program says what can be felt: [row, semi-axes].
function listOf(entries) {
  const list = new ArrayBuffer(16 * entries.length);
  entries.forEach(([row, semiAxes], i) => {
    new Uint32Array(list)[4 * i] = row;
    new Float32Array(list).set(semiAxes, 4 * i + 1);
  });
  return list;
}

function kept(...gaussians) {
  const all = new Kept(new Float32Array(gaussians.flat()));
  all.keep(listOf(gaussians.map((_, row) => [row, [0.1, 0.1, 0.1]])));
  return all;
}

test('what is kept is what the program says, in any order, and as large', () => {
  const scene = kept(gaussian([0, 0, 0]), gaussian([1, 0, 0]), gaussian([2, 0, 0]));
  assert.equal(scene.count, 3);
  scene.keep(listOf([[2, [0.375, 0.75, 1.5]], [0, [1, 1, 1]]]));
  assert.equal(scene.count, 2);
  assert.deepEqual([...scene.nearest([1, 0, 0], 3)].sort(), [0, 2]);
  assert.deepEqual([...scene.at(2).semiAxes], [0.375, 0.75, 1.5]);
  assert.deepEqual(scene.hit([1, 0, -1], [0, 0, 1]), { distance: 1, felt: false, opacity: 1 });
  assert.equal(scene.hitKept([1, 0, -1], [0, 0, 1]), null, 'nothing else is there');
  assert.ok(Math.abs(scene.hitKept([-1, 0, 0], [1, 0, 0]).distance - scene.hit([-1, 0, 0], [1, 0, 0]).distance) < 1e-6, 'what is cut off is behind');
  assert.ok(Math.abs(scene.hitKept([0.5, 0, 0], [1, 0, 0]).distance - 1.5) < 1e-6, 'and here before');
  assert.ok(Math.abs(scene.hit([0.5, 0, 0], [1, 0, 0]).distance - 0.5) < 1e-6);
  scene.keep(listOf([[1, [1, 1, 1]], [3, [1, 1, 1]]])); // the scene has no row 3
  assert.deepEqual([...scene.nearest([0, 0, 0], 3)], [1]);
  scene.keep(new ArrayBuffer(0));
  assert.equal(scene.box, null);
});

test('the nearest are chosen', () => {
  const scene = kept(...[5, 1, 9, 3, 7].map((x) => gaussian([x, 0, 0])));
  assert.deepEqual([...scene.nearest([0, 0, 0], 2)], [1, 3]);
  assert.equal(scene.nearest([0, 0, 0], 50).length, 5);
});

test('of many that are as near, no more are chosen than were asked for', () => {
  const around = Array.from({ length: 300 }, (_, i) => gaussian([Math.cos(i), Math.sin(i), 0]));
  const scene = kept(...around, gaussian([0, 0, 0.5]), gaussian([0, 0, 3]));
  const rows = [...scene.nearest([0, 0, 0], 100)];
  assert.equal(rows.length, 100);
  assert.ok(rows.includes(300) && !rows.includes(301));
});

test('the box leaves out the few that are far away', () => {
  const scene = kept(...Array.from({ length: 200 }, (_, i) => gaussian([i / 199, 0, 0])), gaussian([1000, 0, 0]));
  assert.ok(scene.box.max[0] < 1.1 && scene.box.min[0] < 0.05);
  const tail = kept(...Array.from({ length: 200 }, (_, i) => gaussian([i / 199, 0, 0])), ...Array.from({ length: 12 }, (_, i) => gaussian([20 * i, 0, 0])));
  assert.ok(tail.box.max[0] < 1.6 && tail.box.max[0] > 1, `${tail.box.max}`);
  assert.equal(kept().box, null);
});

test('the box has what stands up from the rest, and not the haze above', () => {
  const floor = Array.from({ length: 4000 }, (_, i) => gaussian([(i % 80) / 80, Math.floor(i / 80) / 50, 0.001 * (i % 7)]));
  const head = Array.from({ length: 60 }, (_, i) => gaussian([0.5 + 0.01 * (i % 3), 0.5, i / 200])); // up to 0.3
  const haze = Array.from({ length: 60 }, (_, i) => gaussian([(i % 8) / 8, (i % 11) / 11, 0.35 + i / 100]));
  const { min, max } = kept(...floor, ...head, ...haze).box;
  assert.ok(Math.abs(max[2] - 0.3) < 0.02, `${max}`);
  assert.ok(min.every((c) => Math.abs(c) < 0.03), `${min}`);
});

test('what is thin hides no more than its opacity, however far the eye is', () => {
  for (const thickness of [1e-4, 1e-7, 0]) {
    // Turned by 60 degrees about x: its face is at y = z / tan 60 degrees.
    const scene = kept(gaussian([0, 0, 0], { deviations: [1, 1, thickness], turn: [0.5, 0, 0, Math.sqrt(0.75)], opacity: 0.75 }));
    for (const [x, y] of [[0, 0], [0.25, 0.125], [-0.5, 0.0625]]) {
      const seen = scene.hit([x, y, -300], [0, 0, 1]);
      const z = y * Math.sqrt(3); // where the ray meets the face
      const expected = 0.75 * Math.exp(-0.5 * (x * x + y * y + z * z));
      assert.ok(Math.abs(seen.opacity - expected) < 1e-4, `${thickness}: ${seen.opacity} and ${expected}`);
      assert.ok(Math.abs(seen.distance - 300 - z) < 1e-4, `${thickness}: ${seen.distance - 300} and ${z}`);
    }
  }
});

test('a ray sees the first solid Gaussian in its way', () => {
  const scene = kept(gaussian([0, 0, 5]), gaussian([0, 0, 2]), gaussian([0, 0, -1]));
  const seen = scene.hit([0, 0, 0], [0, 0, 1]);
  assert.ok(Math.abs(seen.distance - 2) < 1e-6 && seen.felt);
  assert.ok(Math.abs(scene.hit([0.1, 0, 0], [0, 0, 2]).distance - 1) < 1e-6); // in units of the direction
  assert.equal(scene.hit([0.5, 0, 0], [0, 0, 1]), null);
  assert.equal(scene.hit([0, 0, 9], [0, 0, 1]), null);
});

test('of many Gaussians a ray sees what it sees of them one by one', () => {
  let seed = 1;
  const random = () => { seed = (48271 * seed) % 2147483647; return seed / 2147483647; };
  const spot = () => [random() - 0.5, random() - 0.5, 0.2 * random()];
  const all = Array.from({ length: 3000 }, (_, i) => gaussian(i % 500 === 0 ? spot().map((c) => 40 * c) : spot(), {
    deviations: [0, 0, 0].map(() => (i % 300 === 0 ? 0.5 : 0.02) * (0.1 + random())), opacity: 0.05 + 0.9 * random() }));
  const scene = kept(...all);
  for (let k = 0; k < 300; ++k) {
    const origin = spot().map((c) => 3 * c);
    const to = spot();
    const direction = k % 10 === 0 ? [0, 0, -1] : to.map((c, i) => c - origin[i]);
    let left = 1;
    for (const [x, y, z, sx, sy, sz, , , , , opacity] of all) { // none of which is turned
      const scaled = (v) => [v[0] / sx, v[1] / sy, v[2] / sz];
      const [o, u] = [scaled([origin[0] - x, origin[1] - y, origin[2] - z]), scaled(direction)];
      const dot = (p, q) => p.reduce((sum, c, i) => sum + c * q[i], 0);
      const t = -dot(o, u) / dot(u, u);
      const square = dot(o, o) - t * t * dot(u, u);
      if (t >= 0 && square < 9) left *= 1 - opacity * Math.exp(-0.5 * square);
    }
    const seen = scene.hit(origin, direction)?.opacity ?? 0;
    if (seen === 0) assert.ok(1 - left < 0.21, `${k}: ${1 - left}`); // too little to count
    else assert.ok(Math.abs(seen - (1 - left)) < 1e-3, `${k}: ${seen}, ${1 - left}`);
  }
});

test('a ray goes through haze, and stops where most of what is seen is', () => {
  const haze = gaussian([0, 0, 1], { opacity: 0.15 });
  const scene = kept(haze, gaussian([0, 0, 3], { opacity: 0.95 }));
  const seen = scene.hit([0, 0, 0], [0, 0, 1]);
  assert.ok(Math.abs(seen.distance - 3) < 1e-6);
  assert.ok(Math.abs(seen.opacity - (1 - 0.85 * 0.05)) < 1e-6, `${seen.opacity}`);
  assert.equal(kept(haze).hit([0, 0, 0], [0, 0, 1]), null, 'what is hardly seen is nothing');
  const veils = kept(...[1, 2, 3, 4].map((z) => gaussian([0, 0, z], { opacity: 0.4 })));
  assert.ok(Math.abs(veils.hit([0, 0, 0], [0, 0, 1]).distance - 2) < 1e-6, 'half of the opacity is before');
});

test('how much is seen before a distance', () => {
  const scene = kept(gaussian([0, 0, 1], { opacity: 0.4 }), gaussian([0, 0, 3], { opacity: 0.9 }), gaussian([5, 0, 2]));
  const before = (distance) => scene.opacityBefore([0, 0, 0], [0, 0, 2], distance); // in units of the direction
  [[0.4, 0], [0.6, 0.4], [1.6, 1 - 0.6 * 0.1]].forEach(([distance, opacity]) => assert.ok(Math.abs(before(distance) - opacity) < 1e-6, `${before(distance)}`));
});

test('what is seen and cut off is not felt, nor is what it hides', () => {
  const scene = kept(gaussian([0, 0, 1]), gaussian([0, 0, 2]));
  scene.keep(listOf([[1, [0.1, 0.1, 0.1]]]));
  const seen = scene.hit([0, 0, 0], [0, 0, 1]);
  assert.ok(Math.abs(seen.distance - 1) < 1e-6 && !seen.felt);
});

test('a ray sees a turned, flat Gaussian on its plane', () => {
  // Flat along z, then turned by 90 degrees about y: flat along x.
  const turn = [0, Math.SQRT1_2, 0, Math.SQRT1_2];
  const scene = kept(gaussian([3, 0, 0], { deviations: [0.5, 0.5, 0.01], turn }));
  assert.ok(Math.abs(scene.hit([0, 0.3, 0.4], [1, 0, 0]).distance - 3) < 1e-3);
  assert.equal(scene.hit([0, 0, 0.9], [0, 1, 0]), null);
});

test('the surface is nearest where a flat Gaussian is, not at its centre', () => {
  const scene = kept(gaussian([0, 0, 0]), gaussian([0, 0, 5]));
  scene.keep(listOf([[0, [1, 1, 0.01]], [1, [1, 1, 0.01]]]));
  const { point, distance } = scene.closest([0, 1], [0.8, -0.5, 0.4]);
  assert.ok(Math.abs(distance - 0.39) < 1e-6, `${distance}`);
  [0.8, -0.5, 0.01].forEach((c, k) => assert.ok(Math.abs(point[k] - c) < 1e-6));
  assert.equal(scene.closest([], [0, 0, 0]), null);
});

test('neighbours are chosen anew after a while, and then are the nearest', () => {
  const scene = kept(...Array.from({ length: 100 }, (_, x) => gaussian([x, 0, 0])));
  const around = new Neighbourhood();
  const at = (x) => Object.assign([x, 0, 0], { x, y: 0, z: 0, toArray: () => [x, 0, 0], clone: () => at(x), distanceTo: (p) => Math.abs(p.x - x) });
  assert.equal(around.follow(scene, at(0), 10), true);
  assert.equal(around.follow(scene, at(1), 10), false);
  assert.equal(around.follow(scene, at(50), 10), true);
  assert.deepEqual([...around.rows].sort((a, b) => a - b).slice(1, 9), [46, 47, 48, 49, 50, 51, 52, 53]);
  around.forget();
  assert.equal(around.follow(scene, at(50), 10), true);
});

test('the strength of a vibration grows with the force, between nothing and all', () => {
  const forces = [0, 0.02, 0.06, 0.1, 0.3, 1, 3, 6, 12];
  const strengths = forces.map((f) => intensity(f, 12));
  assert.equal(strengths[0], 0);
  assert.equal(strengths[1], 0);
  for (let i = 2; i < forces.length; ++i) assert.ok(strengths[i] > strengths[i - 1], `${forces[i]} N`);
  assert.equal(strengths.at(-1), 1);
  assert.equal(intensity(50, 12), 1);
});

test('contact begins with a click, goes on as a hum, and ends', () => {
  const haptics = new Haptics();
  const at = (now, newtons) => haptics.update({ force: [0, 0, newtons], forceMax: 12, slidingSpeed: 0, now });
  assert.equal(at(0, 0), null);
  const click = at(10, 1);
  assert.equal(click.kind, 'click');
  assert.ok(click.intensity > intensity(1, 12));
  assert.equal(at(20, 1), null); // the click is not cut short
  assert.equal(at(60, 1).kind, 'hum');
  assert.ok(at(80, 4).intensity > at(100, 1).intensity);
  assert.equal(at(120, 0), null);
  assert.equal(at(140, 1).kind, 'click');
  assert.equal(haptics.update({ force: null, forceMax: 12, slidingSpeed: 0, now: 200 }), null);
});

test('sliding is felt as grains, the more the farther', () => {
  const grains = (speed) => {
    const haptics = new Haptics();
    for (let now = 0; now < 2000; now += 10) haptics.update({ force: [0, 0, 1], forceMax: 12, slidingSpeed: speed, now });
    return haptics.pulses.filter((p) => p.kind === 'grain').length;
  };
  assert.equal(grains(0), 0);
  assert.ok(grains(0.1) > 20 && grains(0.1) > 1.5 * grains(0.05));
});

test('sliding is what goes across the force', () => {
  assert.ok(Math.abs(slidingSpeed([0.3, 0.4, 2], [0, 0, 5]) - 0.5) < 1e-12);
  assert.equal(slidingSpeed([1, 0, 0], [0, 0, 0]), 0);
  assert.equal(slidingSpeed(null, [0, 0, 1]), 0);
});

test('changes that wait for an answer are put together, and none is lost', async () => {
  const asked = [];
  const answers = [];
  const connection = {
    subscribe() {},
    ask: (name, type, { json }) => {
      asked.push(JSON.parse(json));
      return new Promise((resolve) => { answers.push(resolve); });
    },
  };
  const parameters = new Parameters(connection, assert.fail);
  parameters.set({ filter: { opacity_min: 0.2 } });
  parameters.set({ filter: { opacity_min: 0.3 } });
  parameters.set({ filter: { sigma: 2 }, tool: [1] });
  parameters.set({ registration: { scale: 2 } });
  parameters.set({ registration: { mirrored: true }, tool: [2] });
  answers[0]();
  await new Promise((done) => { setImmediate(done); });
  assert.deepEqual(asked, [
    { filter: { opacity_min: 0.2 } },
    { filter: { opacity_min: 0.3, sigma: 2 }, registration: { scale: 2, mirrored: true }, tool: [2] },
  ]);
});
