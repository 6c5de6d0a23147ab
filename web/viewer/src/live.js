// State of the loop: the newest message of every topic, and its time of reception.

import { isNumber } from '../../shared/format.js';
import { ownHand } from './address.js';

export const staleAfter = 500; // age at which a message is stale. Unit: [ms].
const added = 0; // actions of visualization_msgs/Marker: ADD, DELETE, DELETEALL
const deleted = 2;
const deletedAll = 3;
const metresPerNewton = 0.02; // scale of the force arrows in the topic `hands`
const ownRate = 10; // least interval of wrenches: the client that holds the tool would get one per tick. Unit: [ms].

const vector = ({ x, y, z }) => [x, y, z];
const quaternion = ({ x, y, z, w }) => [x, y, z, w];

/// A pose as {position: [x, y, z], orientation: [x, y, z, w]}.
const poseOf = ({ position, orientation }) => ({ position: vector(position), orientation: quaternion(orientation) });

function applyMarkers(known, { markers }) {
  for (const marker of markers) {
    const key = `${marker.ns}/${marker.id}`;
    if (marker.action === deletedAll) known.clear();
    else if (marker.action === deleted) known.delete(key);
    else if (marker.action === added) known.set(key, marker);
  }
}

// Values of a DiagnosticStatus, with numeric texts converted to numbers.
function diagnosticValues(status) {
  const asValue = (text) => (text !== '' && isNumber(Number(text)) ? Number(text) : text);
  return Object.fromEntries(status.values.map(({ key, value }) => [key, asValue(value)]));
}

function ellipsoid(marker) {
  return { id: marker.id, ...poseOf(marker.pose), semiAxes: vector(marker.scale).map((d) => 0.5 * d) };
}

export class Live {
  tool = null; // pose of the tool
  velocity = null; // of the tool. Unit: [m/s].
  proxy = null; // pose of the proxy
  wrench = null; // {force, torque}, world frame. Unit: [N], [N m].
  diagnostics = null; // {level, values}
  #toolMarkers = new Map();
  #contactMarkers = new Map();
  #handMarkers = []; // of all hands, if there are several
  #heard = new Map(); // time of the last message, by topic
  #listeners = new Map();
  #waiting = new Map(); // callbacks that wait for the next message, by topic

  constructor(connection) {
    this.connection = connection;
    const { subscribe } = this.#subscriber(connection);
    subscribe('measured_cp', 'geometry_msgs/PoseStamped', (m) => { this.tool = poseOf(m.pose); });
    subscribe('measured_cv', 'geometry_msgs/TwistStamped', (m) => { this.velocity = vector(m.twist.linear); });
    subscribe('proxy_cp', 'geometry_msgs/PoseStamped', (m) => { this.proxy = poseOf(m.pose); });
    subscribe('spatial/servo_cf', 'geometry_msgs/WrenchStamped', (m) => {
      this.wrench = { force: vector(m.wrench.force), torque: vector(m.wrench.torque) };
    }, { throttle_rate: ownRate });
    subscribe('tool', 'visualization_msgs/MarkerArray', (m) => applyMarkers(this.#toolMarkers, m));
    // Markers are incremental changes, so no message may be dropped.
    subscribe('contacts', 'visualization_msgs/MarkerArray', (m) => applyMarkers(this.#contactMarkers, m),
      { queue_length: 10 });
    subscribe('hands', 'visualization_msgs/MarkerArray', (m) => { this.#handMarkers = m.markers; });
    subscribe('diagnostics', 'diagnostic_msgs/DiagnosticArray', ({ status: [status] }) => {
      this.diagnostics = { level: status.level, values: diagnosticValues(status) };
    });
    // A new connection starts with empty state.
    connection.onChange((connected) => { if (!connected) this.#forget(); });
  }

  #subscriber(connection) {
    return {
      subscribe: (name, type, apply, rest) => connection.subscribe(name, type, (message) => {
        apply(message);
        this.#heard.set(name, performance.now());
        for (const listener of this.#listeners.get(name) ?? []) listener();
        for (const done of this.#waiting.get(name) ?? []) done();
        this.#waiting.delete(name);
      }, rest),
    };
  }

  #forget() {
    this.#heard.clear();
    this.#toolMarkers.clear();
    this.#contactMarkers.clear();
    this.#handMarkers = [];
  }

  /// Calls `listener` after every message of a topic.
  on(name, listener) {
    this.#listeners.set(name, [...(this.#listeners.get(name) ?? []), listener]);
  }

  /// Resolves after the next message of a topic, or after `most` ms without one.
  next(name, most) {
    return new Promise((done) => {
      this.#waiting.set(name, [...(this.#waiting.get(name) ?? []), done]);
      setTimeout(done, most);
    });
  }

  /// Returns whether the last message of a topic is still valid.
  isFresh(name) {
    const heard = this.#heard.get(name);
    return this.connection.connected && heard !== undefined && performance.now() - heard < staleAfter;
  }

  /// Force on the tool, or null if it is unknown.
  get force() {
    return this.isFresh('spatial/servo_cf') ? this.wrench.force : null;
  }

  /// [{id, position, orientation, semiAxes}], one per part.
  get toolParts() {
    return [...this.#toolMarkers.values()].map(ellipsoid);
  }

  /// All hands except this page's: [{name, color, force, parts}]. `force` in N; `parts` as in toolParts.
  get others() {
    const others = new Map();
    for (const marker of this.isFresh('hands') ? this.#handMarkers : []) {
      const name = marker.ns.replace(/\/force$/, '');
      if (name === ownHand) continue;
      const { r, g, b } = marker.color;
      if (!others.has(name)) others.set(name, { name, color: [r, g, b], force: 0, parts: [] });
      const other = others.get(name);
      if (marker.ns === name) other.parts.push({ ...ellipsoid(marker), color: other.color });
      else other.force = arrowLength(marker) / metresPerNewton;
    }
    return [...others.values()];
  }

  /// [{id, position, orientation, semiAxes, color, normal: {from, to} or null, depth or null}].
  get contacts() {
    return [...this.#contactMarkers.values()].filter((m) => m.ns === 'contacts').map((marker) => {
      const arrow = this.#contactMarkers.get(`normals/${marker.id}`);
      const normal = arrow ? arrowEnds(arrow) : null;
      const depth = normal && Math.hypot(...normal.to.map((v, k) => v - normal.from[k]));
      return { ...ellipsoid(marker), color: [marker.color.r, marker.color.g, marker.color.b], normal, depth };
    });
  }
}

function arrowLength(marker) {
  const { from, to } = arrowEnds(marker);
  return Math.hypot(...to.map((v, k) => v - from[k]));
}

// An ARROW goes from its first point to its second, or, without points, along x of its pose for scale.x.
function arrowEnds({ points, pose, scale }) {
  if (points?.length === 2) return { from: vector(points[0]), to: vector(points[1]) };
  const { position, orientation: { x, y, z, w } } = pose;
  const axis = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
  const from = vector(position);
  return { from, to: from.map((v, k) => v + scale.x * axis[k]) };
}
