// Objects of the 3D view: the scene, the tool's path, the contacts, the tool, the grid. The theme sets their colours
// through `userData.color` of the materials.

import {
  BufferAttribute, BufferGeometry, Color, DataTexture, GreaterDepth, Group, LineBasicMaterial,
  LineSegments, Points, PointsMaterial, UnsignedByteType, RGBAFormat, Vector3,
} from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';

const pathTolerance = 1 / 4000; // largest error of the simplified path, as a fraction of the extent of the view
const ghostOpacity = 0.5; // opacity of objects hidden by the scene
const contactSize = 6; // Unit: [px].
const sceneDensity = 1.15; // diameter of the scene's points, in extent / sqrt(count)
const normalOpacity = 0.45;
const ringSegments = 48;
const mostArrows = 80; // largest number of force arrows; more would hide each other

/// Colours of K_min from lowest to highest, also used by the legend.
export const rampColors = ['#6a3fc4', '#e0407b', '#ffae00'];
const ramp = rampColors.map((c) => new Color(c));

function rampColor(share, target) {
  const s = Math.min(Math.max(share, 0), 1) * (ramp.length - 1);
  const i = Math.min(Math.floor(s), ramp.length - 2);
  return target.lerpColors(ramp[i], ramp[i + 1], s - i);
}

function themed(material, name) {
  material.userData.color = name;
  return material;
}

function geometryOf(positions, colors, normalized) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  if (colors) geometry.setAttribute('color', new BufferAttribute(colors, 3, normalized));
  return geometry;
}

// Texture for round points, which are squares by default.
function discTexture() {
  const size = 32;
  const data = new Uint8Array(4 * size * size).fill(255);
  for (let i = 0; i < size * size; ++i) {
    const x = (i % size) - 0.5 * (size - 1);
    const y = Math.floor(i / size) - 0.5 * (size - 1);
    const edge = 0.5 * size - Math.hypot(x, y);
    data[4 * i + 3] = 255 * Math.min(Math.max(edge, 0), 1);
  }
  const texture = new DataTexture(data, size, size, RGBAFormat, UnsignedByteType);
  texture.needsUpdate = true;
  return texture;
}
const disc = discTexture();

function pointsMaterial(options) {
  return new PointsMaterial({ map: disc, alphaTest: 0.5, ...options });
}

/// The scene's Gaussians as points, about as large as their spacing if they lie on a surface. `focal` is cot(fov / 2),
/// which three.js omits from the size of points.
export function sceneCloud(scene, extent, focal) {
  const count = scene.positions.length / 3;
  const hasColors = scene.colors !== null;
  const size = (focal * sceneDensity * extent) / Math.sqrt(count);
  const material = pointsMaterial({ size, vertexColors: hasColors });
  if (!hasColors) themed(material, '--muted');
  const cloud = new Points(geometryOf(scene.positions, scene.colors, true), material);
  cloud.frustumCulled = false; // non-finite positions would break the bounding sphere
  return cloud;
}

// Simplifies a polyline to within `tolerance` (Ramer-Douglas-Peucker, with a stack instead of recursion). Returns the
// indices of the remaining points.
function simplified(points, from, to, tolerance) {
  const kept = [from];
  const pending = [[from, to]];
  while (pending.length > 0) {
    const [first, last] = pending.pop();
    const { index, distance } = farthest(points, first, last);
    if (distance > tolerance) pending.push([index, last], [first, index]);
    else kept.push(last);
  }
  return kept;
}

// Finds the point between two others that is farthest from the line segment between them.
function farthest(points, first, last) {
  const a = points[first];
  const d = points[last].map((v, k) => v - a[k]);
  const length2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  let [index, largest] = [first, 0];
  for (let i = first + 1; i < last; ++i) {
    const [x, y, z] = [points[i][0] - a[0], points[i][1] - a[1], points[i][2] - a[2]];
    const along = length2 > 0 ? (x * d[0] + y * d[1] + z * d[2]) / length2 : 0;
    const s = Math.min(Math.max(along, 0), 1);
    const distance = Math.hypot(x - s * d[0], y - s * d[1], z - s * d[2]);
    if (distance > largest) [index, largest] = [i, distance];
  }
  return { index, distance: largest };
}

// Path as pairs of points, separated by contact. A step belongs to the row at its end.
function pathSegments(run, rows, positions, extent) {
  const segments = { free: [], touching: [] };
  const touches = (i) => run.col.colliding[rows[i]] > 0;
  for (let from = 0; from + 1 < rows.length;) {
    const contact = touches(from + 1);
    let to = from + 1;
    while (to + 1 < rows.length && touches(to + 1) === contact) ++to;
    const kept = simplified(positions, from, to, pathTolerance * extent);
    const pairs = contact ? segments.touching : segments.free;
    for (let i = 1; i < kept.length; ++i) pairs.push(...positions[kept[i - 1]], ...positions[kept[i]]);
    from = to;
  }
  return segments;
}

function fatLines(segments, colorName, width, extra) {
  const geometry = new LineSegmentsGeometry().setPositions(segments);
  const lines = new LineSegments2(geometry, themed(new LineMaterial({ linewidth: width, ...extra }), colorName));
  lines.frustumCulled = false;
  return lines;
}

const ghostLook = { depthFunc: GreaterDepth, depthWrite: false, transparent: true, opacity: ghostOpacity };

/// Path of the tool centre, thicker in contact; parts hidden by the scene are translucent.
export function toolPath(run, rows, positions, extent) {
  const group = new Group();
  const { free, touching } = pathSegments(run, rows, positions, extent);
  if (free.length > 0) {
    group.add(fatLines(free, '--path', 1.6), fatLines(free, '--path', 1.6, ghostLook));
  }
  if (touching.length > 0) {
    group.add(fatLines(touching, '--colliding', 3.4), fatLines(touching, '--colliding', 3.4, ghostLook));
  }
  return group;
}

/// Range of K_min for the colours: [0, largest].
export function kMinRange(contacts) {
  let high = 0;
  for (const { kMin } of contacts) high = Math.max(high, kMin ?? 0);
  return [0, high > 0 ? high : 1];
}

/// Contact points coloured by K_min; those hidden by the scene are translucent.
export function contactPoints(contacts) {
  const positions = new Float32Array(contacts.flatMap((c) => c.position));
  const colors = new Float32Array(positions.length);
  const [, high] = kMinRange(contacts);
  const color = new Color();
  contacts.forEach((c, i) => rampColor((c.kMin ?? 0) / high, color).toArray(colors, 3 * i));
  const geometry = geometryOf(positions, colors, false);
  const look = { size: contactSize, sizeAttenuation: false, vertexColors: true };
  return new Group().add(
    new Points(geometry, pointsMaterial(look)),
    new Points(geometry, pointsMaterial({ ...look, ...ghostLook })));
}

/// Short lines along the contact normals; null if there are none.
export function contactNormals(contacts, length) {
  const ends = contacts.filter((c) => c.normal).flatMap(({ position: p, normal: n }) => {
    const scale = length / (Math.hypot(...n) || 1);
    return [...p, p[0] + scale * n[0], p[1] + scale * n[1], p[2] + scale * n[2]];
  });
  if (ends.length === 0) return null;
  const geometry = geometryOf(new Float32Array(ends), null, false);
  return new LineSegments(geometry,
    themed(new LineBasicMaterial({ transparent: true, opacity: normalOpacity }), '--normal'));
}

// Selects at most about `most` rows in contact, at equal distances along the path.
function spreadAlongContact(run, rows, positions, most) {
  const step = (i) => Math.hypot(...positions[i].map((v, k) => v - positions[i - 1][k]));
  const touching = [...rows.keys()].filter((i) => i > 0 && run.col.force[rows[i]] > 0);
  const spacing = touching.reduce((sum, i) => sum + step(i), 0) / most;
  let way = spacing;
  return touching.filter((i) => {
    way += step(i);
    if (way < spacing) return false;
    way = 0;
    return true;
  });
}

/// Force on the tool as arrows along the path, to a common scale; null if there is none. `usual` is the length of the
/// 90 % quantile of the forces in contact, so that a few peaks do not make all others small.
export function forceArrows(run, rows, positions, usual) {
  const forces = run.col.force.filter((f) => f > 0).sort((a, b) => a - b);
  if (forces.length === 0) return null;
  const reference = forces[Math.floor(0.9 * (forces.length - 1))];
  const segments = [];
  for (const i of spreadAlongContact(run, rows, positions, mostArrows)) {
    const force = new Vector3(run.col.fx[rows[i]], run.col.fy[rows[i]], run.col.fz[rows[i]]);
    const length = (usual * force.length()) / reference;
    const along = force.normalize();
    const aside = new Vector3(along.y, -along.x, 0);
    if (aside.lengthSq() < 1e-6) aside.set(1, 0, 0);
    aside.normalize();
    const from = new Vector3(...positions[i]);
    const tip = from.clone().addScaledVector(along, length);
    segments.push(...from, ...tip);
    for (const side of [1, -1]) {
      segments.push(...tip, ...tip.clone().addScaledVector(along, -0.25 * length).addScaledVector(aside, 0.12 * side * length));
    }
  }
  return fatLines(segments, '--force', 2.2, { transparent: true });
}

// Rings of a unit sphere: four meridians and three parallels.
function unitSphereRings() {
  const vertices = [];
  const addRing = (at) => {
    for (let i = 0; i < ringSegments; ++i) {
      vertices.push(...at((2 * Math.PI * i) / ringSegments), ...at((2 * Math.PI * (i + 1)) / ringSegments));
    }
  };
  for (const turn of [0, 0.25, 0.5, 0.75]) {
    const [c, s] = [Math.cos(turn * Math.PI), Math.sin(turn * Math.PI)];
    addRing((a) => [c * Math.cos(a), s * Math.cos(a), Math.sin(a)]);
  }
  for (const z of [-0.6, 0, 0.6]) {
    const r = Math.sqrt(1 - z * z);
    addRing((a) => [r * Math.cos(a), r * Math.sin(a), z]);
  }
  return new Float32Array(vertices);
}

/// The tool as wireframe ellipsoids with a dot at its handle, drawn over everything else, to be visible inside the
/// surface that it touches and from afar.
export function toolMarker(parts) {
  const onTop = { depthTest: false, depthWrite: false, transparent: true };
  const sphere = geometryOf(unitSphereRings(), null, false);
  const material = themed(new LineBasicMaterial({ ...onTop, opacity: 0.85 }), '--tool');
  const rings = parts.map(({ semiAxes, position, orientation }) => {
    const ellipsoid = new LineSegments(sphere, material);
    ellipsoid.scale.set(...semiAxes);
    ellipsoid.position.set(...position);
    ellipsoid.quaternion.set(...orientation);
    return ellipsoid;
  });
  const dot = new Points(geometryOf(new Float32Array(3), null, false),
    themed(pointsMaterial({ ...onTop, size: 8, sizeAttenuation: false }), '--tool'));
  const marker = new Group().add(...rings, dot);
  marker.traverse((part) => { part.renderOrder = 10; });
  return marker;
}

/// Horizontal grid at height `z` that covers the box, with lines at multiples of `step`.
export function floorGrid(box, step, z) {
  const [x0, y0] = [0, 1].map((k) => Math.floor(box.min[k] / step) - 1);
  const [x1, y1] = [0, 1].map((k) => Math.ceil(box.max[k] / step) + 1);
  const ends = [];
  for (let x = x0; x <= x1; ++x) ends.push(x * step, y0 * step, z, x * step, y1 * step, z);
  for (let y = y0; y <= y1; ++y) ends.push(x0 * step, y * step, z, x1 * step, y * step, z);
  return new LineSegments(geometryOf(new Float32Array(ends), null, false),
    themed(new LineBasicMaterial({ depthWrite: false }), '--floor'));
}
