// Force as sound: a knock at the onset of contact, a tone that rises with the force, and noise that follows the sliding
// speed.

import { intensity } from './haptics.js';

const tone = { lowest: 110, highest: 440, gain: 0.12 }; // lowest and highest in [Hz]
const noise = { fastest: 0.2, gain: 0.25, centre: 1400 }; // sliding speed of the loudest noise in [m/s]; centre in [Hz]
const knock = { gain: 0.5, length: 0.05 }; // length in [s]
const follow = 0.03; // time constant of levels. Unit: [s].

export class Sound {
  level = 0; // level of the tone, from 0 to 1
  texture = 0; // level of the noise
  knocks = 0;
  on = false; // off at first: browsers allow sound only after a click or a key
  #context = null;
  #touching = false;

  toggle() {
    this.on = !this.on;
    this.#context ??= this.#make();
    return this.on ? this.#context.resume() : this.#context.suspend();
  }

  /// Call before every frame.
  update({ force, forceMax, slidingSpeed }) {
    const magnitude = force && this.on ? Math.hypot(...force) : 0;
    this.level = intensity(magnitude, forceMax);
    this.texture = this.level > 0 ? Math.min(slidingSpeed / noise.fastest, 1) : 0;
    const begins = this.level > 0 && !this.#touching;
    this.#touching = this.level > 0;
    if (!this.#context) return;
    const now = this.#context.currentTime;
    this.tone.gain.gain.setTargetAtTime(tone.gain * this.level, now, follow);
    this.tone.source.frequency.setTargetAtTime(tone.lowest * (tone.highest / tone.lowest) ** this.level, now, follow);
    this.noise.gain.gain.setTargetAtTime(noise.gain * this.texture * this.level, now, follow);
    if (begins) this.#knock(now);
  }

  #knock(now) {
    this.knocks += 1;
    const { gain } = this.knock.gain;
    gain.cancelScheduledValues(now);
    gain.setValueAtTime(knock.gain * (0.4 + 0.6 * this.level), now);
    gain.exponentialRampToValueAtTime(1e-3, now + knock.length);
  }

  #make() {
    const context = new AudioContext();
    const voice = (source, ...between) => {
      const gain = new GainNode(context, { gain: 0 });
      [source, ...between, gain].reduce((from, to) => from.connect(to)).connect(context.destination);
      source.start();
      return { source, gain };
    };
    const hiss = () => new AudioBufferSourceNode(context, { buffer: whiteNoise(context), loop: true });
    this.tone = voice(new OscillatorNode(context, { type: 'triangle' }));
    this.noise = voice(hiss(), new BiquadFilterNode(context, { type: 'bandpass', frequency: noise.centre, Q: 0.8 }));
    this.knock = voice(hiss(), new BiquadFilterNode(context, { type: 'lowpass', frequency: 900 }));
    return context;
  }
}

// Buffer of one second of white noise.
function whiteNoise(context) {
  const buffer = new AudioBuffer({ length: context.sampleRate, sampleRate: context.sampleRate });
  const samples = buffer.getChannelData(0);
  for (let i = 0; i < samples.length; ++i) samples[i] = 2 * Math.random() - 1;
  return buffer;
}
