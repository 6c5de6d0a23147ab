// The first size of a scene that does not say how large it is: one at which the tool in it is as large as in a hand. It is
// asked for once a scene, taken, said, and changed with one slider.

import { Vector3 } from 'three';

import { byId, element } from '../../shared/dom.js';
import { button, hint, numberField } from './fields.js';
import { formatLength } from './format.js';

const range = 30; // times smaller and larger than the proposal, that the slider reaches
const mostTries = 4; // where a connection is lost before the answer comes
const same = 1.05; // a proposal that is nearer to what is there changes nothing

/// `propose` promises a setup as JSON, or null; `onSized` is called once a new size is there.
export class FirstSize {
  #asked = null; // the scene, as it is called, that has been asked about
  #unanswered = 0; // times that it has been asked in vain
  #proposal = null; // {scale, was}
  #shown = 0; // the scale that the view is framed for

  constructor({ parameters, splats, propose, onSized }) {
    Object.assign(this, { parameters, splats, propose, onSized });
    this.said = hint('');
    this.slide = { min: 1 / range, max: range, log: true };
    const set = (scale) => this.#set(scale);
    this.scale = numberField({ label: 'Size of the scene', unit: 'm per captured unit', name: 'first_scale', min: 0, slide: this.slide, onRelease: true }, set);
    const back = button('As captured', () => set(this.#proposal.was), { name: 'size-as-captured' });
    const close = button('×', () => { byId('size').hidden = true; }, { name: 'size-close' });
    close.setAttribute('aria-label', 'Keep this size');
    byId('size').append(element('div', { className: 'size-text' }, this.said, close), this.scale.node, element('div', { className: 'buttons' }, back));
  }

  /// To be called once a scene is there.
  async begin() {
    const { scene, registration, demo } = this.parameters.current;
    byId('size').hidden = true;
    this.#proposal = null;
    this.#shown = registration.scale;
    const name = JSON.stringify(scene);
    // A device in a hand has its own idea of where it is: there nothing moves by itself.
    if (!registration.assumed?.includes('scale') || demo === undefined || this.#asked === name) return;
    this.#asked = name;
    const text = await this.propose();
    if (text === null) this.#asked = null;
    this.#unanswered = text === null ? this.#unanswered + 1 : 0;
    if (text === null || JSON.stringify(this.parameters.current.scene) !== name) return;
    const { scale, frame } = JSON.parse(text);
    if (!this.parameters.current.registration.assumed?.includes('scale')) return; // somebody has said it meanwhile
    this.#take(scale.value ?? registration.scale, registration, frame.value);
  }

  #take(scale, registration, frame) {
    const turned = frame !== null && frame !== registration.frame && registration.assumed.includes('frame');
    const sized = Math.max(scale / registration.scale, registration.scale / scale) > same;
    if (!sized && !turned) return;
    this.#proposal = { scale, was: registration.scale, turned };
    Object.assign(this.slide, { min: scale / range, max: scale * range });
    byId('size').hidden = false;
    this.parameters.set({ registration: { scale, ...(turned ? { frame } : {}) } });
  }

  #set(scale) {
    this.parameters.set({ registration: { scale } });
  }

  /// To be called once the scene is where the parameters say.
  follow({ registration, busy }) {
    if (this.#unanswered > 0 && this.#unanswered < mostTries) this.begin();
    if (!this.#proposal) return;
    this.scale.show(registration.scale);
    if (registration.scale === this.#shown || busy) return;
    this.#shown = registration.scale;
    this.#say();
    this.onSized();
  }

  #say() {
    const across = formatLength(this.splats.box.getSize(new Vector3()).length());
    const upright = this.#proposal.turned ? ', and stands upright' : '';
    this.said.textContent = this.#shown === this.#proposal.scale
      ? `The file does not say how large this is. It is now ${across} across${upright}: the tool is as large in it as in a hand.`
      : `It is now ${across} across.`;
  }
}
