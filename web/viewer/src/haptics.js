// What a vibration can say of a force: that contact began, how strong it is, and that the tool slides.
//
// A motor cannot push. Equal ratios of force are about equally far apart to a hand (Weber), so the strength
// grows with the logarithm of the force; above the least force that is told at all it never says nothing.

const leastForce = 0.05; // below, nothing is told. Unit: [N].
const ratioForce = 0.1; // above, equal ratios are equal steps. Unit: [N].
const floor = 0.12; // below, motors do not start; a share of the strongest
const click = { duration: 25, floor: 0.6 }; // when contact begins. Unit: [ms].
const hum = 40; // a pulse outlasts a frame, so that it is felt as one. Unit: [ms].
const grain = 0.003; // of the way that the tool slides between two grains. Unit: [m].
const grainShare = 0.3; // by which a grain is stronger
const kept = 400; // pulses that are remembered for a look at them

/// How strong a vibration tells a force, from 0 to 1: monotone in `force`, 1 at `forceMax` and above.
export function intensity(force, forceMax) {
  if (force < leastForce) return 0;
  const share = Math.log1p(force / ratioForce) / Math.log1p(forceMax / ratioForce);
  return Math.min(floor + (1 - floor) * share, 1);
}

export class Haptics {
  pulses = [];
  #touching = false;
  #quietUntil = 0; // a hum must not end the click
  #way = 0; // slid since the last grain. Unit: [m].
  #last = 0;

  /// The pulse that is due at `now` in ms, as {t, intensity, duration, force, kind}, or null.
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

/// The speed of the tool across the force: how fast it slides. Unit: [m/s].
export function slidingSpeed(velocity, force) {
  if (!velocity || !force) return 0;
  const [magnitude, speed] = [Math.hypot(...force), Math.hypot(...velocity)];
  if (magnitude === 0) return 0;
  const along = velocity.reduce((sum, v, k) => sum + v * force[k], 0) / magnitude;
  return Math.sqrt(Math.max(speed * speed - along * along, 0));
}

/// Plays a pulse on a gamepad: a headset's controller or one on the desk.
export function play(gamepad, { intensity: strength, duration }) {
  const motor = gamepad.hapticActuators?.[0];
  const played = motor?.pulse ? motor.pulse(strength, duration)
    : gamepad.vibrationActuator?.playEffect?.('dual-rumble', { duration, strongMagnitude: strength, weakMagnitude: strength });
  played?.catch?.(() => {}); // one pulse less
}
