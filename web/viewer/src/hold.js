// The user's hand: its pose is published while it holds the tool.

import { Quaternion, Vector3 } from 'three';

const refusalShown = 1500; // duration of the display after a refusal. Unit: [ms].

export class Hold {
  hand = new Vector3(); // position in the world. Unit: [m].
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
    // A hidden page must not keep pressing on a surface.
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

  /// Whether several input methods hold the tool.
  get isShared() {
    return this.#by.size > 1;
  }

  /// Takes the tool at its current pose. Returns false if that is unknown.
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
    this.publish(); // the tool stays at the last pose
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

  /// Called when the program has reported that someone else holds the tool.
  refused() {
    this.#refusedAt = performance.now();
  }

  /// Whether the hand was released recently: the program still counts a silent hand as present for a second.
  get justLetGo() {
    return performance.now() - this.#endedAt < refusalShown;
  }

  get isRefused() {
    return performance.now() - this.#refusedAt < refusalShown;
  }

  /// Call before every frame.
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
