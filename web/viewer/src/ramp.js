// Colour ramp from just touching to deep, the same as the program's ramp for K_min.

import { Color } from 'three';

export const rampColors = ['#59126e', '#a1266b', '#de4a4a', '#f78a24', '#f5de66'];
const ramp = rampColors.map((c) => new Color(c).convertLinearToSRGB());
const mixed = new Color();

/// Colour [r, g, b] in sRGB; `share` is in [0, 1].
export function rampColor(share) {
  const s = Math.min(Math.max(share, 0), 1) * (ramp.length - 1);
  const i = Math.min(Math.floor(s), ramp.length - 2);
  return mixed.lerpColors(ramp[i], ramp[i + 1], s - i).toArray();
}
