// Objects that show the haptic state reported by the program: tool, proxy, contacts, normals, force and torque.

import {
  BufferGeometry, BufferAttribute, DynamicDrawUsage, Group, LineBasicMaterial, LineSegments, Quaternion, Vector3,
} from 'three';

import { niceFloor } from '../../shared/format.js';
import { Arrow } from './arrow.js';
import { Ellipsoids, shellMaterial, solidMaterial } from './ellipsoids.js';
import { fill, setVisible } from './fill.js';
import { rampColor } from './ramp.js';
import { toolSize } from './tool_shape.js';

const mostContacts = 256;
const mostParts = 256;
const longestForce = 12; // length of the arrow of the device's largest force, in tool sizes; usual ones are 10 % of it
const leastLength = 240; // least length of that arrow, to be visible for a small tool in a large scene. Unit: [px].
const leastThickness = 2.5; // least thickness of its shaft. Unit: [px].
const normalLength = 0.6; // length of the longest contact normal, in tool sizes
const leastForce = 0.01; // smallest force that is drawn. Unit: [N].
const [middle, rim] = [0.5, 0.95]; // opacities of the tool
const staleShare = 0.3; // factor on them while the tool's position is unknown
const proxyShare = 0.02; // least distance of the proxy from the tool to be drawn, in tool sizes

// Render order, after the splats (0) and the felt ellipsoids (1): contacts are visible through the tool.
const order = { hidden: 2, proxy: 3, tool: 4, contacts: 5, normals: 6, torque: 7, force: 8 };

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

export class FeltObjects {
  group = new Group();
  colorBy = 'k_min';
  size = 0.03; // tool size, see toolSize(). Unit: [m].
  pixel = 0; // size of a pixel at the tool; 0: unknown. Unit: [m].
  forceMax = 10; // largest force of the device. Unit: [N].
  parts = []; // parts of the tool: {semi_axes, position, orientation}

  constructor() {
    // Contacts coincide with felt ellipsoids: the offset draws them in front.
    const bright = solidMaterial({ polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -4 });
    this.contacts = new Ellipsoids(mostContacts, bright, { order: order.contacts });
    this.tool = new Ellipsoids(mostParts, shellMaterial('--tool', middle, rim), { order: order.tool });
    // Faint copy of the tool, visible where the felt surface hides it.
    const hidden = shellMaterial('--tool', 0.06, 0.3, { depthTest: false });
    this.hidden = new Ellipsoids(mostParts, hidden, { order: order.hidden });
    this.proxy = new Ellipsoids(mostParts, shellMaterial('--proxy', 0, 0.95, { depthTest: false }), { order: order.proxy });
    this.others = new Ellipsoids(mostParts, solidMaterial({ opacity: 0.55 }), { order: order.tool });
    this.normals = normalLines();
    this.force = new Arrow('--force', order.force);
    this.torque = new Arrow('--torque', order.torque);
    this.group.add(this.contacts, this.others, this.normals, this.hidden, this.proxy, this.tool, this.torque, this.force);
  }

  /// Sets the sizes that depend on the tool and the device.
  follow({ tool, device }) {
    this.parts = tool;
    this.size = toolSize(tool);
    this.forceMax = device.force_max || 10;
  }

  /// Length of a force arrow per newton, shown in the legend. Unit: [m/N].
  get forceLength() {
    return niceFloor(Math.max(longestForce * this.size, leastLength * this.pixel) / this.forceMax);
  }

  /// Shows the newest state. A stale tool keeps its place, but without force and contacts. Returns whether anything
  /// changed.
  update(live, shown) {
    const parts = live.toolParts;
    const fresh = live.isFresh('measured_cp');
    const changes = [
      this.tool.show(parts),
      this.hidden.show(parts),
      this.others.show(live.others.flatMap((other) => other.parts)),
      this.#dim(!fresh),
      this.#showProxy(live, shown.proxy && fresh),
      this.#showContacts(live.isFresh('contacts') ? live.contacts : [], shown),
      this.#showWrench(live, shown),
    ];
    return changes.includes(true);
  }

  #showWrench(live, shown) {
    const wrench = live.force && live.tool ? live.wrench : { force: [0, 0, 0], torque: [0, 0, 0] };
    const at = live.tool?.position ?? [0, 0, 0];
    const thickness = Math.max(0.09 * this.size, leastThickness * this.pixel);
    const scaled = (v, by) => v.map((c) => c * by);
    const { forceLength } = this;
    const force = this.force.point(at, scaled(wrench.force, shown.force ? forceLength : 0), thickness, leastForce * forceLength);
    // A torque has the length of the force that produces it with a lever of the tool size.
    const torqueLength = forceLength / this.size;
    const torque = this.torque.point(at, scaled(wrench.torque, shown.torque ? torqueLength : 0), thickness, leastForce * forceLength);
    return force || torque;
  }

  #dim(stale) {
    const by = stale ? staleShare : 1;
    const { uniforms } = this.tool.material;
    const changed = uniforms.rim.value !== by * rim;
    uniforms.rim.value = by * rim;
    uniforms.fill.value = by * middle;
    return changed;
  }

  #showProxy({ proxy, tool }, wanted) {
    const apart = wanted && proxy && tool && distance(proxy.position, tool.position) > proxyShare * this.size;
    const toggled = setVisible(this.proxy, Boolean(apart));
    return apart ? this.proxy.show(this.parts.map((part) => placed(part, proxy))) || toggled : toggled;
  }

  #showContacts(contacts, shown) {
    this.contactIds = contacts.map((c) => c.id);
    const deepest = Math.max(0, ...contacts.map((c) => c.depth ?? 0));
    this.deepest = deepest;
    const colored = this.colorBy === 'depth'
      ? contacts.map((c) => ({ ...c, color: rampColor(deepest > 0 ? (c.depth ?? 0) / deepest : 0) })) : contacts;
    const toggled = setVisible(this.contacts, shown.contacts);
    const other = this.contacts.show(colored);
    const length = deepest > 0 ? (normalLength * this.size) / deepest : 0;
    const ends = shown.normals ? contacts.filter((c) => c.normal).slice(0, mostContacts) : [];
    const lines = setLines(this.normals, ends.map(({ normal: { from, to } }) =>
      [from, from.map((v, k) => v + length * (to[k] - v))]));
    return toggled || other || lines;
  }

  /// Orientation of the handle at a pose.
  turnOf({ orientation }) {
    return new Quaternion(...orientation);
  }

  /// Centre of the drawn contact with an id, or null. Unit: [m].
  drawnCentre(id) {
    const index = this.contactIds?.indexOf(id) ?? -1;
    return index >= 0 ? this.contacts.centre(index) : null;
  }
}

// World pose of a tool part for the handle at `pose`.
function placed(part, pose) {
  const [w, x, y, z] = part.orientation;
  const handle = new Quaternion(...pose.orientation);
  const position = new Vector3(...part.position).applyQuaternion(handle).add(new Vector3(...pose.position));
  const orientation = handle.clone().multiply(new Quaternion(x, y, z, w));
  return { position: position.toArray(), orientation: orientation.toArray(), semiAxes: part.semi_axes };
}

function normalLines() {
  const positions = new BufferAttribute(new Float32Array(6 * mostContacts), 3).setUsage(DynamicDrawUsage);
  const material = new LineBasicMaterial({ transparent: true, opacity: 0.8, depthTest: false });
  material.userData.color = '--normal';
  const lines = new LineSegments(new BufferGeometry().setAttribute('position', positions), material);
  lines.frustumCulled = false;
  lines.renderOrder = order.normals;
  return lines;
}

// Sets the ends of lines. Returns whether anything changed.
function setLines(lines, ends) {
  const { attributes: { position }, drawRange } = lines.geometry;
  const moved = fill(position.array, 0, ends.flat(2));
  if (moved) position.needsUpdate = true;
  const changed = moved || drawRange.count !== 2 * ends.length;
  lines.geometry.setDrawRange(0, 2 * ends.length);
  return changed;
}
