// Substitutes for force feedback: vibration of controllers, and sound.

import { byId } from '../../shared/dom.js';
import { Haptics, play, slidingSpeed } from './haptics.js';
import { Sound } from './sound.js';

export class ForceCues {
  haptics = new Haptics();
  sound = new Sound();

  constructor({ live, hold, parameters, keys, headset }) {
    Object.assign(this, { live, hold, parameters, keys, headset });
    byId('sound').addEventListener('click', () => this.toggleSound());
  }

  toggleSound() {
    this.sound.toggle();
    byId('sound').setAttribute('aria-pressed', String(this.sound.on));
  }

  /// Call before every frame.
  update() {
    const { live, hold } = this;
    const force = {
      forceMax: this.parameters.current?.device.force_max ?? 1,
      slidingSpeed: slidingSpeed(live.velocity, live.force),
    };
    this.sound.update({ ...force, force: live.force });
    const pulse = this.haptics.update({ ...force, force: hold.active ? live.force : null, now: performance.now() });
    if (!pulse) return;
    this.headset.pulse(pulse);
    if (hold.holds('keys') && this.keys.gamepad) play(this.keys.gamepad, pulse);
  }
}
