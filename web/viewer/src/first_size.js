// Initial size of a scene of unknown scale: one at which the tool has its usual size in a hand. It is requested once
// per scene, applied, reported, and can be changed with a slider.

import { Vector3 } from 'three';

import { byId, element } from '../../shared/dom.js';
import { button, hint, numberField } from './fields.js';
import { formatLength } from './format.js';
import { notify } from './notices.js';

const range = 30; // factor that the slider reaches below and above the proposal
const mostTries = 4; // largest number of requests, if the connection is lost before the answer
const same = 1.05; // ratio to the current scale below which a proposal is not applied

/// `propose` resolves to a setup as JSON, or null; `onSized` is called once a new size is applied.
export class FirstSize {
  #asked = null; // name of the scene of the last request
  #unanswered = 0; // number of requests without an answer
  #proposal = null; // {scale, was, turned}
  #shown = 0; // scale for which the view is framed

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

  /// Call once a scene is loaded.
  async begin() {
    const { scene, registration, demo } = this.parameters.current;
    byId('size').hidden = true;
    this.#proposal = null;
    this.#shown = registration.scale;
    const name = JSON.stringify(scene);
    // With a real device (no demo), the scene must not move by itself. Nothing is assumed where world coordinates are in use.
    if (!registration.assumed?.includes('scale') || demo === undefined || this.#asked === name) return;
    this.#asked = name;
    const text = await this.propose();
    if (text === null) this.#asked = null;
    this.#unanswered = text === null ? this.#unanswered + 1 : 0;
    if (text === null || JSON.stringify(this.parameters.current.scene) !== name) return;
    const { scale, frame } = JSON.parse(text);
    const { scale: now, assumed } = this.parameters.current.registration;
    if (!assumed?.includes('scale')) { // set, or the tool was taken, meanwhile
      if (now === registration.scale) notify('The scene keeps the size of its file. “Propose a setup” in Placement finds a scale.', 'message');
      return;
    }
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

  /// Call once the scene is placed as in the parameters.
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
    const upright = this.#proposal.turned ? ' and upright' : '';
    this.said.textContent = this.#shown === this.#proposal.scale
      ? `The file does not state its scale. The scene is now ${across} across${upright}, to suit the size of the tool.`
      : `The scene is now ${across} across.`;
  }
}
