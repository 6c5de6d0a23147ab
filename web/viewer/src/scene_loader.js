// Loads the scene that the program has, once, and shows how far it is.

import { byId } from '../../shared/dom.js';
import { notify } from './notices.js';

const retryAfter = 2000; // Unit: [ms].

export class SceneLoader {
  #wanted = '';
  #loading = new AbortController();
  #parameters = null;

  constructor(splats, onLoaded) {
    Object.assign(this, { splats, onLoaded });
  }

  follow(parameters) {
    this.#parameters = parameters;
    this.splats.follow(parameters);
    const wanted = JSON.stringify(parameters.scene);
    if (wanted === this.#wanted) return;
    this.#wanted = wanted;
    this.#loading.abort(); // what came before is not wanted any more
    this.#loading = new AbortController();
    this.#load(parameters.scene, this.#loading.signal);
  }

  async #load(scene, signal) {
    const [box, bar, text] = ['progress', 'progress-bar', 'progress-text'].map(byId);
    box.hidden = false;
    text.textContent = `Loading ${scene.name}`;
    bar.value = 0;
    try {
      await this.splats.load(scene, (share) => { if (!signal.aborted) bar.value = share; }, signal);
      this.splats.follow(this.#parameters);
      this.onLoaded();
    } catch (error) {
      if (signal.aborted) return;
      notify(`The scene could not be loaded: ${error.message ?? error}`);
      setTimeout(() => { if (!signal.aborted) this.#load(scene, signal); }, retryAfter);
    }
    box.hidden = true;
  }
}
