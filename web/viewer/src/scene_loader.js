// Loads the scene that the program has, once, and shows how far it is; and which of it can be felt, whenever that
// changes.

import { byId } from '../../shared/dom.js';
import { notify } from './notices.js';

const retryAfter = 2000; // Unit: [ms].

export class SceneLoader {
  #wanted = '';
  #wantedList = '';
  #loading = new AbortController();
  #loaded = false; // the wanted one
  #isLoading = false; // the wanted one
  #asking = new AbortController();
  #parameters = null;

  /// `onLoaded` is called once a scene is there, and what of it can be felt is known.
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
    this.#loading.abort(); // what came before is not wanted any more
    this.#loading = new AbortController();
    this.#load(parameters.scene, this.#loading.signal);
  }

  // What the program is still reading, before there is anything to load.
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
      notify(`The scene could not be loaded: ${error.message ?? error}`);
      setTimeout(() => { if (!signal.aborted) this.#load(scene, signal); }, retryAfter);
    }
    this.#isLoading = false;
    box.hidden = true;
  }

  // The program says which list is the newest as soon as it has one.
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
      if (isFirst) this.onLoaded();
    } catch (error) {
      if (signal.aborted) return;
      notify(`What can be felt could not be loaded: ${error.message ?? error}`);
      this.#wantedList = '';
      setTimeout(() => this.#followList(), retryAfter);
    }
  }
}
