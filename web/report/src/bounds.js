// Bounds of the region that the camera shows.

const outlierShare = 0.02; // fraction of a scene's points at either end of an axis: floaters and sky
const sceneReach = 1.5; // distance around the path within which the scene is shown, in path extents
const sampledPoints = 5000; // number of scene points used for quantiles and outline

// Bounding box {min, max} of points [x, y, z]; null if there are none.
function boxOf(points) {
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  for (const point of points) {
    for (let k = 0; k < 3; ++k) {
      min[k] = Math.min(min[k], point[k]);
      max[k] = Math.max(max[k], point[k]);
    }
  }
  return min[0] <= max[0] ? { min, max } : null;
}

export function diagonal(box) {
  return Math.hypot(...box.max.map((high, k) => high - box.min[k]));
}

export function centre(box) {
  return box.max.map((high, k) => 0.5 * (high + box.min[k]));
}

function sample(list) {
  const stride = Math.max(1, Math.floor(list.length / sampledPoints));
  return list.filter((_, i) => i % stride === 0);
}

function sampleScene({ positions }) {
  const count = positions.length / 3;
  const stride = Math.max(1, Math.floor(count / sampledPoints));
  const points = [];
  for (let i = 0; i < count; i += stride) {
    const point = [...positions.subarray(3 * i, 3 * i + 3)];
    if (point.every(Number.isFinite)) points.push(point);
  }
  return points;
}

// Bounding box of at least one point, without outliers.
function boxWithoutOutliers(points) {
  const cut = Math.floor(outlierShare * (points.length - 1));
  const sorted = [0, 1, 2].map((k) => points.map((p) => p[k]).sort((a, b) => a - b));
  return { min: sorted.map((v) => v[cut]), max: sorted.map((v) => v[v.length - 1 - cut]) };
}

const grow = (box, by) => ({ min: box.min.map((v) => v - by), max: box.max.map((v) => v + by) });
const contains = (box, point) => point.every((v, k) => v >= box.min[k] && v <= box.max[k]);

function union(own, scene) {
  const reach = grow(own, sceneReach * diagonal(own));
  return {
    min: own.min.map((v, k) => Math.min(v, Math.max(scene.min[k], reach.min[k]))),
    max: own.max.map((v, k) => Math.max(v, Math.min(scene.max[k], reach.max[k]))),
  };
}

/// Returns {box, outline}: the box to show, which contains the path, the contacts and the scene near them, and points
/// that outline its content.
export function frame(run, path, margin) {
  const touched = [...path, ...run.contacts.map((c) => c.position)];
  const scene = run.scene ? sampleScene(run.scene) : [];
  const sceneBox = scene.length > 0 ? boxWithoutOutliers(scene) : null;
  const touchedBox = boxOf(touched);
  const own = touchedBox && grow(touchedBox, margin);
  const box = own && sceneBox ? union(own, sceneBox) : own ?? sceneBox ?? { min: [-1, -1, -1], max: [1, 1, 1] };
  return { box, outline: [...sample(touched), ...scene].filter((point) => contains(box, point)) };
}
