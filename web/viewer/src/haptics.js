// Vibration cues of a force: onset of contact, magnitude, and sliding.
//
// A vibration motor cannot render a force. Equal ratios of force are perceived as about equal steps (Weber), so the
// strength grows with the logarithm of the force; above the smallest rendered force it is never zero.

const leastForce = 0.05; // smallest rendered force. Unit: [N].
const ratioForce = 0.1; // force above which the strength is logarithmic. Unit: [N].
const floor = 0.12; // least strength at which motors start, as a fraction of the strongest
const click = { duration: 25, floor: 0.6 }; // pulse at the onset of contact. Unit: [ms].
const hum = 40; // duration of a pulse: longer than a frame, so that pulses are felt as one. Unit: [ms].
const grain = 0.003; // sliding distance between two grains. Unit: [m].
const grainShare = 0.3; // additional strength of a grain
const kept = 400; // number of pulses kept for inspection

/// Strength of the vibration for a force, from 0 to 1: monotonic in `force`, 1 at `forceMax` and above.
export function intensity(force, forceMax) {
  if (force < leastForce) return 0;
  const share = Math.log1p(force / ratioForce) / Math.log1p(forceMax / ratioForce);
  return Math.min(floor + (1 - floor) * share, 1);
}

export class Haptics {
  pulses = [];
  #touching = false;
  #quietUntil = 0; // no hum before, as it would end the click
  #way = 0; // sliding distance since the last grain. Unit: [m].
  #last = 0;

  /// Pulse due at `now` in ms: {t, intensity, duration, force, kind}, or null.
  update({ force, forceMax, slidingSpeed, now }) {
    const seconds = Math.min((now - this.#last) / 1000, 0.1);
    this.#last = now;
    const magnitude = force ? Math.hypot(...force) : 0;
    const strength = intensity(magnitude, forceMax);
    const begins = strength > 0 && !this.#touching;
    this.#touching = strength > 0;
    if (!this.#touching) return null;
    if (begins) {
      this.#quietUntil = now + click.duration;
      return this.#remember(now, Math.min(click.floor + (1 - click.floor) * strength, 1), click.duration, magnitude, 'click');
    }
    if (now < this.#quietUntil) return null;
    this.#way += slidingSpeed * seconds;
    const isGrain = this.#way > grain;
    if (isGrain) this.#way %= grain;
    return this.#remember(now, isGrain ? Math.min(strength + grainShare, 1) : strength, hum, magnitude, isGrain ? 'grain' : 'hum');
  }

  #remember(t, strength, duration, force, kind) {
    const pulse = { t, intensity: strength, duration, force, kind };
    this.pulses.push(pulse);
    if (this.pulses.length > kept) this.pulses.shift();
    return pulse;
  }
}

/// Sliding speed: the tool's velocity component perpendicular to the force. Unit: [m/s].
export function slidingSpeed(velocity, force) {
  if (!velocity || !force) return 0;
  const [magnitude, speed] = [Math.hypot(...force), Math.hypot(...velocity)];
  if (magnitude === 0) return 0;
  const along = velocity.reduce((sum, v, k) => sum + v * force[k], 0) / magnitude;
  return Math.sqrt(Math.max(speed * speed - along * along, 0));
}

/// Plays a pulse on a gamepad or a headset's controller.
export function play(gamepad, { intensity: strength, duration }) {
  const motor = gamepad.hapticActuators?.[0];
  const played = motor?.pulse ? motor.pulse(strength, duration)
    : gamepad.vibrationActuator?.playEffect?.('dual-rumble', { duration, strongMagnitude: strength, weakMagnitude: strength });
  played?.catch?.(() => {}); // a lost pulse is harmless
}
