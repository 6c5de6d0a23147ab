// Loads the program's scene once, with a progress bar, and the list of its Gaussians that can be felt on every change.

import { byId } from '../../shared/dom.js';
import { notify } from './notices.js';
import { Passing } from './splats.js';

const retryAfter = 2000; // delay before the list is requested again. Unit: [ms].

export class SceneLoader {
  #wanted = '';
  #wantedList = '';
  #loading = new AbortController();
  #loaded = false; // whether the wanted scene is loaded
  #isLoading = false; // whether the wanted scene is being loaded
  #asking = new AbortController();
  #parameters = null;

  /// `onLoaded` is called once a scene and the list of what can be felt are loaded.
  constructor(splats, onLoaded) {
    Object.assign(this, { splats, onLoaded });
  }

  follow(parameters) {
    this.#parameters = parameters;
    this.#showOpening(parameters.busy);
    this.splats.place(parameters.registration);
    const wanted = JSON.stringify(parameters.scene);
    if (wanted === this.#wanted) {
      this.#followList();
      return;
    }
    this.#wanted = wanted;
    this.#loaded = false;
    this.#loading.abort(); // the previous scene is obsolete
    this.#loading = new AbortController();
    this.#load(parameters.scene, this.#loading.signal);
  }

  // Shows the progress of the program while it is still opening the scene.
  #showOpening(busy) {
    if (this.#isLoading) return;
    const [box, bar, text] = ['progress', 'progress-bar', 'progress-text'].map(byId);
    const opens = busy.startsWith('opening ');
    box.hidden = !opens;
    if (!opens) return;
    text.textContent = `${busy[0].toUpperCase()}${busy.slice(1)}`;
    bar.value = Number(/(\d+) %/.exec(busy)?.[1] ?? 0) / 100;
  }

  async #load(scene, signal) {
    const [box, bar, text] = ['progress', 'progress-bar', 'progress-text'].map(byId);
    this.#isLoading = true;
    box.hidden = false;
    text.textContent = `Loading ${scene.name}`;
    bar.value = 0;
    try {
      await this.splats.load(scene, (share) => { if (!signal.aborted) bar.value = share; }, signal);
      this.#loaded = true;
      this.#wantedList = '';
      this.#followList();
    } catch (error) {
      if (signal.aborted) return;
      if (this.#retries(error, scene, signal, text)) return;
    }
    this.#isLoading = false;
    box.hidden = true;
  }

  // Loads the scene once more after a failure that passes; otherwise says once that it cannot be drawn. What was drawn before is not
  // what is felt: it goes.
  #retries(error, scene, signal, text) {
    this.splats.clear();
    if (!(error instanceof Passing)) {
      notify(`${scene.name} can be felt, but not drawn: ${error.message ?? error}`);
      return false;
    }
    text.textContent = `Loading ${scene.name}: ${error.message}`;
    setTimeout(() => { if (!signal.aborted) this.#load(scene, signal); }, error.after);
    return true;
  }

  // Loads the list if the program has announced a newer one.
  async #followList() {
    const { felt } = this.#parameters;
    if (!felt || felt.tag === this.#wantedList || !this.#loaded) return;
    this.#wantedList = felt.tag;
    this.#asking.abort();
    this.#asking = new AbortController();
    const { signal } = this.#asking;
    const isFirst = !this.splats.knowsFelt;
    try {
      await this.splats.feel(felt.url, signal);
      if (isFirst && this.splats.knowsFelt) this.onLoaded(); // else another scene came meanwhile
    } catch (error) {
      if (signal.aborted) return;
      notify(`The list of touchable Gaussians could not be loaded: ${error.message ?? error}`);
      this.#wantedList = '';
      setTimeout(() => this.#followList(), retryAfter);
    }
  }
}
