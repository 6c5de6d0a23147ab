// The hand that a person lends: where it is is published while the tool is held, and stops when it is let go.

import { Quaternion, Vector3 } from 'three';

const refusalShown = 1500; // after the last refusal. Unit: [ms].

export class Hold {
  hand = new Vector3(); // in the world. Unit: [m].
  orientation = new Quaternion();
  #by = new Set(); // 'pointer', 'keys', 'headset', 'approach'
  #seq = 0;
  #refusedAt = -Infinity;
  #endedAt = -Infinity;
  #listeners = [];

  constructor(connection, live) {
    this.connection = connection;
    this.live = live;
    connection.onChange((connected) => { if (!connected) this.endAll(); });
    // A hand that nobody sees must not lean on anything.
    window.addEventListener('blur', () => this.endAll());
    document.addEventListener('visibilitychange', () => { if (document.hidden) this.endAll(); });
  }

  onChange(listener) {
    this.#listeners.push(listener);
  }

  get active() {
    return this.#by.size > 0;
  }

  holds(by) {
    return this.#by.has(by);
  }

  /// Whether more than one holds it.
  get isShared() {
    return this.#by.size > 1;
  }

  /// Takes the tool where it is. False if it is not known where that is.
  begin(by) {
    if (!this.live.isFresh('measured_cp')) return false;
    if (!this.active) {
      this.hand.set(...this.live.tool.position);
      this.orientation.set(...this.live.tool.orientation);
    }
    this.#by.add(by);
    this.#tell();
    return true;
  }

  end(by) {
    if (!this.holds(by)) return;
    this.publish(); // it stays where the hand is now
    this.#by.delete(by);
    this.#endedAt = performance.now();
    this.#tell();
  }

  endAll() {
    if (!this.active) return;
    this.#by.clear();
    this.#endedAt = performance.now();
    this.#tell();
  }

  #tell() {
    for (const listener of this.#listeners) listener();
  }

  /// The program has said that someone else holds the tool.
  refused() {
    this.#refusedAt = performance.now();
  }

  /// The program takes a hand that is silent for one that is still there for a second.
  get justLetGo() {
    return performance.now() - this.#endedAt < refusalShown;
  }

  get isRefused() {
    return performance.now() - this.#refusedAt < refusalShown;
  }

  /// To be called before every frame.
  publish() {
    if (!this.active) return;
    const now = Date.now();
    const { x, y, z, w } = this.orientation.normalize();
    this.connection.publish('client/measured_cp', 'geometry_msgs/PoseStamped', {
      header: {
        seq: this.#seq++,
        stamp: { secs: Math.floor(now / 1000), nsecs: (now % 1000) * 1e6 },
        frame_id: 'world',
      },
      pose: { position: { x: this.hand.x, y: this.hand.y, z: this.hand.z }, orientation: { x, y, z, w } },
    });
  }
}
