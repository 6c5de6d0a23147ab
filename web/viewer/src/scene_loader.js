// Loads the scene that the program has, once, and shows how far it is.

import { byId } from './dom.js';
import { notify } from './notices.js';

const retryAfter = 2000; // Unit: [ms].

export class SceneLoader {
  #wanted = '';
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
    this.#load(parameters.scene, wanted);
  }

  async #load(scene, wanted) {
    const [box, bar, text] = ['progress', 'progress-bar', 'progress-text'].map(byId);
    box.hidden = false;
    text.textContent = `Loading ${scene.name}`;
    bar.value = 0;
    try {
      await this.splats.load(scene, (share) => { bar.value = share; });
      this.splats.follow(this.#parameters);
      this.onLoaded();
    } catch (error) {
      notify(`The scene could not be loaded: ${error.message}`);
      setTimeout(() => { if (this.#wanted === wanted) this.#load(scene, wanted); }, retryAfter);
    }
    box.hidden = true;
  }
}
