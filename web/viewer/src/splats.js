// The captured scene, unfiltered, placed by the program's registration; and the part of it that can be felt, as
// reported by the program.

import { Box3, Group, Ray, Vector3 } from 'three';

import { httpUrl } from './address.js';
import { sceneLayer } from './backdrop.js';
import { BatchedSpark } from './batched_spark.js';
import { Ellipsoids, solidMaterial } from './ellipsoids.js';
import { readGaussians } from './kept.js';
import { MirroredMesh } from './mirrored_mesh.js';
import { Neighbourhood } from './neighbourhood.js';

const mostFelt = { desk: 50000, headset: 8000 }; // largest number of drawn ellipsoids
const splatBudget = 500000; // largest number of splats on a standalone headset
const standalone = /Quest|OculusBrowser|Android|Pico|VisionOS/i;
const searched = 4000; // ellipsoids around the tool that closest() examines

/// An error that passes: the same request may succeed `after` a time. Unit: [ms].
export class Passing extends Error {
  constructor(message, after = 2000) {
    super(message);
    this.after = after;
  }
}

// Response to a request. Rejects with what the program says against it.
async function request(url, signal) {
  const response = await fetch(httpUrl(url), { signal }).catch((error) => {
    throw signal.aborted ? error : new Passing(error.message);
  });
  if (response.ok) return response;
  const said = (await response.text()).trim() || `${url}: ${response.status} ${response.statusText}`;
  const after = response.headers.get('Retry-After');
  throw after ? new Passing(said, 1000 * after) : new Error(said);
}

// Download of the scene as {stream, length, failure()}. An interruption ends the stream and is stored as the failure:
// Spark does not handle a failing stream, and the worker that waits for its next chunk would leak.
async function download(scene, onProgress, signal) {
  const response = await request(scene.url, signal);
  const length = Number(response.headers.get('Content-Length')) || scene.bytes;
  const reader = response.body.getReader();
  let loaded = 0;
  let failure = null;
  const stream = new ReadableStream({
    async pull(controller) {
      try {
        const { done, value } = await reader.read();
        if (done) {
          controller.close();
          return;
        }
        loaded += value.byteLength;
        onProgress(Math.min(loaded / length, 1));
        controller.enqueue(value);
      } catch (error) {
        failure = new Passing(error.message);
        controller.close();
      }
    },
    cancel: (reason) => reader.cancel(reason),
  });
  return { stream, length, failure: () => failure };
}

export class Splats {
  sceneShown = true;
  knowsFelt = false; // whether it is known which of the loaded Gaussians can be felt
  group = new Group(); // transform from the captured frame to the world
  #mesh = null;
  #kept = null;
  #felt = null; // the drawn ellipsoids
  #drawn = new Neighbourhood();
  #around = new Neighbourhood();
  #most = mostFelt.desk;

  /// accumExtSplats keeps centres in single precision: in half precision they would deviate from the felt ellipsoids.
  constructor(renderer, onDirty) {
    this.onDirty = onDirty;
    this.spark = new BatchedSpark({ renderer, accumExtSplats: true, onDirty });
    this.spark.layers.set(sceneLayer);
    this.group.matrixAutoUpdate = false;
  }

  /// Loads a scene. Rejects, and discards the loaded data, if `signal` aborts it.
  async load(scene, onProgress, signal) {
    const { stream, length, failure } = await download(scene, onProgress, signal);
    const mesh = new MirroredMesh({ stream, streamLength: length, fileType: scene.format, fileName: scene.name, extSplats: true, enableLod: false });
    try {
      await mesh.initialized.catch((error) => { throw failure() ?? error; });
      if (failure()) throw failure();
      signal.throwIfAborted();
    } catch (error) {
      mesh.dispose();
      throw error;
    }
    this.clear();
    this.#mesh = mesh;
    this.#kept = readGaussians(mesh);
    mesh.visible = this.sceneShown;
    mesh.layers.set(sceneLayer);
    this.group.add(mesh);
  }

  /// Removes the scene.
  clear() {
    this.#mesh?.dispose();
    this.#mesh?.removeFromParent();
    this.#mesh = null;
    this.#kept = null;
    this.knowsFelt = false;
    this.#felt?.show([]);
    this.#forget();
    this.onDirty();
  }

  /// Loads the list of Gaussians that can be felt.
  async feel(url, signal) {
    const kept = this.#kept;
    const list = await (await request(url, signal)).arrayBuffer();
    signal.throwIfAborted();
    if (kept !== this.#kept) return; // another scene has been loaded meanwhile
    kept.keep(list);
    this.knowsFelt = true;
    this.#forget();
    this.onDirty();
  }

  showScene(shown) {
    this.sceneShown = shown;
    if (this.#mesh) this.#mesh.visible = shown;
    this.onDirty();
  }

  /// Places the scene with the program's registration.
  place(registration) {
    this.group.matrix.fromArray(registration.matrix);
    this.group.matrixWorldNeedsUpdate = true;
    this.#forget();
    this.onDirty();
  }

  #forget() {
    this.#drawn.forget();
    this.#around.forget();
  }

  // Transforms a point of the world to the captured frame.
  #local(point) {
    return new Vector3(...point).applyMatrix4(this.group.matrix.clone().invert());
  }

  /// Whether the splats are still to be sorted for the current camera.
  get isSorting() {
    return this.spark.sorting || this.spark.sortDirty;
  }

  /// Call when the graphics context has been restored.
  drawAnew() {
    if (this.#mesh) this.#mesh.needsUpdate = true;
    this.onDirty();
  }

  get keptCount() {
    return this.#kept?.count ?? 0;
  }

  /// Diameters of the ellipsoid of a Gaussian, in the world. Unit: [m].
  feltScale(row) {
    const size = this.group.matrix.getMaxScaleOnAxis();
    return [...this.#kept.at(row).semiAxes].map((s) => 2 * size * s);
  }

  get feltCount() {
    return this.#felt?.visible ? this.#felt.count : 0;
  }

  showFelt(shown) {
    if (shown) this.#felt ??= this.#makeFelt();
    if (this.#felt) this.#felt.visible = shown;
    this.onDirty();
  }

  #makeFelt() {
    const material = solidMaterial();
    material.userData.color = '--felt';
    const felt = new Ellipsoids(mostFelt.desk, material, { order: 1, detail: 2 });
    this.group.add(felt);
    this.onMaterial?.(felt);
    return felt;
  }

  /// Draws the felt ellipsoids nearest to a point of the world, if enabled. Returns whether anything changed.
  update(point) {
    if (!this.#felt?.visible || !this.#kept) return false;
    if (!this.#drawn.follow(this.#kept, this.#local(point), this.#most)) return false;
    return this.#felt.show(this.#drawn.rows.map((row) => this.#kept.at(row)));
  }

  /// Nearest point of the felt ellipsoids to a point of the world: {point, distance} in the world, or null.
  closest(point) {
    if (this.keptCount === 0) return null;
    const local = this.#local(point);
    this.#around.follow(this.#kept, local, searched);
    const found = this.#kept.closest(this.#around.rows, local.toArray());
    if (!found) return null;
    const at = new Vector3(...found.point).applyMatrix4(this.group.matrix);
    return { point: at, distance: at.distanceTo(new Vector3(...point)) };
  }

  /// Visible surface along a ray of the world: {point, felt, opacity}, or null. `felt` is true if it can be felt.
  look(ray) {
    return this.#along(ray, (kept, ...line) => kept.hit(...line));
  }

  /// The same for felt Gaussians only: they may lie behind filtered ones.
  lookForFelt(ray) {
    return this.#along(ray, (kept, ...line) => kept.hitKept(...line));
  }

  #along(ray, hit) {
    if (!this.#kept) return null;
    const local = new Ray().copy(ray).applyMatrix4(this.group.matrix.clone().invert());
    const seen = hit(this.#kept, local.origin.toArray(), local.direction.toArray());
    return seen && { ...seen, point: local.at(seen.distance, new Vector3()).applyMatrix4(this.group.matrix) };
  }

  /// Opacity between two points of the world.
  opacityBetween(from, to) {
    const [start, end] = [this.#local(from), this.#local(to)];
    return this.#kept?.opacityBefore(start.toArray(), end.sub(start).toArray(), 1) ?? 0;
  }

  /// Visible point along a ray of the world, if it can be felt; else null.
  pick(ray) {
    const seen = this.look(ray);
    return seen?.felt ? seen.point : null;
  }

  /// Bounding box of the felt ellipsoids' main part, in the world; empty before a scene is loaded.
  get box() {
    const box = this.#kept?.box;
    return box ? new Box3(new Vector3(...box.min), new Vector3(...box.max)).applyMatrix4(this.group.matrix) : new Box3();
  }

  /// Limits the number of ellipsoids, and on a standalone headset that of splats.
  async enterHeadset() {
    this.#most = mostFelt.headset;
    this.#drawn.forget();
    const mesh = this.#mesh;
    if (!standalone.test(navigator.userAgent) || !mesh || mesh.numSplats <= splatBudget) return;
    this.spark.lodSplatCount = splatBudget;
    if (!mesh.extSplats.lodSplats) await mesh.createLodSplats();
    mesh.enableLod = this.#most === mostFelt.headset; // the headset may have been left meanwhile
  }

  leaveHeadset() {
    this.#most = mostFelt.desk;
    this.#drawn.forget();
    if (this.#mesh) this.#mesh.enableLod = false;
  }
}
