// A ball of flat Gaussians as an INRIA .ply, and where its surface is.

export const radius = 0.1; // Unit: [m].
const shC0 = 0.28209479177387814; // of the constant spherical harmonic
const properties = ['x', 'y', 'z', 'f_dc_0', 'f_dc_1', 'f_dc_2', 'opacity',
  'scale_0', 'scale_1', 'scale_2', 'rot_0', 'rot_1', 'rot_2', 'rot_3'];
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

function toPly(gaussians) {
  const header = `ply\nformat binary_little_endian 1.0\nelement vertex ${gaussians.length}\n${
    properties.map((name) => `property float ${name}\n`).join('')}end_header\n`;
  const values = gaussians.flatMap(({ center, rgb, opacity, deviations, turn }) => [
    ...center, ...rgb.map((c) => (c - 0.5) / shC0), logit(opacity), ...deviations.map(Math.log), ...turn]);
  return Buffer.concat([Buffer.from(header), Buffer.from(new Float32Array(values).buffer)]);
}
