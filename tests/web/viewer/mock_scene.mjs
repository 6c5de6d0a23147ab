// Scenes as INRIA .ply: a ball of flat Gaussians, and what its mirror image is told from.

export const radius = 0.1; // Unit: [m].
const shC0 = 0.28209479177387814; // of the constant spherical harmonic
const restCount = 45; // of the coefficients of degrees 1 to 3: 15 of red, of green, of blue
const properties = ['x', 'y', 'z', 'f_dc_0', 'f_dc_1', 'f_dc_2', ...Array.from({ length: restCount }, (_, i) => `f_rest_${i}`), 'opacity',
  'scale_0', 'scale_1', 'scale_2', 'rot_0', 'rot_1', 'rot_2', 'rot_3', 'filter_3D'];
const logit = (p) => Math.log(p / (1 - p));

// Evenly spread directions: Fibonacci's spiral.
function direction(i, count) {
  const z = 1 - (2 * i + 1) / count;
  const angle = i * Math.PI * (3 - Math.sqrt(5));
  const r = Math.sqrt(1 - z * z);
  return [r * Math.cos(angle), r * Math.sin(angle), z];
}

// The turn that takes z to n, as w, x, y, z.
function turnFromZ([x, y, z]) {
  const q = z > -0.999999 ? [1 + z, -y, x, 0] : [0, 1, 0, 0];
  const length = Math.hypot(...q);
  return q.map((c) => c / length);
}

/// `count` Gaussians, every tenth of them too faint to be felt at an opacity cut of 0.1. The right half (x > 0) is
/// orange, the left blue.
export function ballScene(count) {
  const spread = radius * Math.sqrt((4 * Math.PI) / count);
  const gaussians = Array.from({ length: count }, (_, i) => {
    const n = direction(i, count);
    return {
      row: i, n, center: n.map((c) => radius * c), turn: turnFromZ(n),
      deviations: [0.6 * spread, 0.6 * spread, 0.1 * spread], opacity: i % 10 === 9 ? 0.05 : 0.95,
      rgb: n[0] > 0 ? [0.9, 0.5, 0.1] : [0.1, 0.4, 0.9],
    };
  });
  return { gaussians, ply: toPly(gaussians) };
}

/// A ball that is beside haze: the middle of both is haze alone.
export function besideHaze(place) {
  const { gaussians } = ballScene(600);
  const haze = Array.from({ length: 60 }, (_, i) => ({
    center: place.map((c) => -(c * i) / 60), turn: [1, 0, 0, 0], deviations: [0.05, 0.05, 0.05], opacity: 0.12, rgb: [0.8, 0.8, 0.8],
  }));
  return sceneOf([...gaussians.map((g) => ({ ...g, center: g.center.map((c, k) => c + place[k]) })), ...haze]);
}

/// A ball with one Gaussian far away and one far larger than the others, as captures have.
export function strayScene() {
  const { gaussians } = ballScene(600);
  const [far, giant] = gaussians.slice(0, 2);
  return sceneOf([...gaussians, { ...far, center: [3, 0, 0] }, { ...giant, deviations: [1, 1, 1] }]);
}

/// One Gaussian of Mip-Splatting, whose filter makes it a quarter larger, and less opaque by the cube of that.
export const mipOpacity = 0.95 * 0.8 ** 3;
export function mipScene() {
  return sceneOf([{ center: [0, 0, 0], turn: [1, 0, 0, 0], deviations: [0.05, 0.05, 0.05], opacity: 0.95, rgb: [0.9, 0.5, 0.1], filter: 0.0375 }]);
}

/// The same scene as text.
export function asciiOf({ ply }) {
  const end = ply.indexOf('end_header\n') + 11;
  const header = ply.toString('latin1', 0, end).replace('binary_little_endian', 'ascii');
  const values = new Float32Array(Uint8Array.from(ply.subarray(end)).buffer);
  const width = header.split('property ').length - 1;
  const lines = Array.from({ length: values.length / width }, (_, i) => values.subarray(width * i, width * (i + 1)).join(' '));
  return Buffer.from(`${header}${lines.join('\n')}\n`);
}

// `rest` are the coefficients of degrees 1 to 3, `filter` is Mip-Splatting's, if a Gaussian has any: then all need them.
function toPly(gaussians) {
  const isHad = (name) => (name.startsWith('f_rest') ? gaussians.some(({ rest }) => rest) : name !== 'filter_3D' || gaussians.some(({ filter }) => filter));
  const named = properties.filter(isHad);
  const header = `ply\nformat binary_little_endian 1.0\nelement vertex ${gaussians.length}\n${
    named.map((name) => `property float ${name}\n`).join('')}end_header\n`;
  const values = gaussians.flatMap(({ center, rgb, rest, opacity, deviations, turn, filter }) => [
    ...center, ...rgb.map((c) => (c - 0.5) / shC0), ...(rest ?? []), logit(opacity), ...deviations.map(Math.log), ...turn, ...(filter ? [filter] : [])]);
  return Buffer.concat([Buffer.from(header), Buffer.from(new Float32Array(values).buffer)]);
}

const needle = (center, turn, rgb) => ({
  center, turn: turn.map((c) => c / Math.hypot(...turn)), rgb, deviations: [0.05, 0.008, 0.006], opacity: 0.99, rest: Array(restCount).fill(0),
});

/// Needles, each of another colour and in another turn, on one side of a white ball whose red grows towards +x.
export function needleScene() {
  const redAlongX = 2; // of degree 1: -y, z, -x
  const ball = { ...needle([0, 0, 0], [1, 0, 0, 0], [0.5, 0.5, 0.5]), deviations: [0.03, 0.03, 0.03] };
  ball.rest[redAlongX] = 0.8;
  return sceneOf([
    needle([0.16, 0, 0.12], [0.9, 0.1, -0.4, 0.1], [0.9, 0.1, 0.1]),
    needle([0.2, 0.02, -0.1], [0.8, -0.2, 0.5, 0.3], [0.1, 0.7, 0.1]),
    needle([0.05, -0.03, -0.2], [0.7, 0.3, 0.2, -0.4], [0.1, 0.2, 0.9]),
    ball,
  ]);
}

/// Flat Gaussians here and there whose colours depend on the direction in all degrees, from a seed.
export function colourfulScene(count, seed) {
  let state = seed;
  const random = (low, high) => { // Park and Miller's generator
    state = (state * 48271) % 2147483647;
    return low + ((high - low) * state) / 2147483647;
  };
  const several = (n, low, high) => Array.from({ length: n }, () => random(low, high));
  return sceneOf(Array.from({ length: count }, () => {
    const [x, y, z] = several(3, -0.1, 0.1);
    return {
      ...needle([x + 0.1, y, 2 * z], several(4, -1, 1), several(3, 0.2, 0.8)),
      deviations: [0.03, 0.012, 0.002], rest: several(restCount, -0.4, 0.4),
    };
  }));
}

/// The same scene with its x axis reversed, in the file itself.
export function mirrorImage({ gaussians }) {
  return sceneOf(gaussians.map((g) => ({ ...g, center: mirrored(g.center), turn: mirroredTurn(g.turn), rest: g.rest.map(mirroredRest) })));
}

export const mirrored = ([x, y, z]) => [-x, y, z];

// A turn goes the other way round in a mirror, and its axis, like a thing, has its x reversed.
function mirroredTurn([w, ...axis]) {
  return [w, ...mirrored(axis).map((c) => -c)];
}

// What is odd in x, of xyz: degree 1 (y, z, x), 2 (xy, yz, zz, xz, xx - yy), 3 (y.., xyz, y.., z.., x.., z.., x..).
function mirroredRest(value, i) {
  const oddInX = [2, 3, 6, 9, 12, 14];
  return oddInX.includes(i % 15) ? -value : value;
}

function sceneOf(gaussians) {
  const rows = gaussians.map((g, row) => ({ ...g, row, n: [0, 0, 1] }));
  return { gaussians: rows, ply: toPly(rows) };
}
