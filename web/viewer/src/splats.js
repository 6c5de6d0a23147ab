// The scene as it was captured, unfiltered, placed by the program's registration; and what of it can be felt, as the
// program says.

import { Box3, Group, Ray, Vector3 } from 'three';

import { httpUrl } from './address.js';
import { sceneLayer } from './backdrop.js';
import { BatchedSpark } from './batched_spark.js';
import { Ellipsoids, solidMaterial } from './ellipsoids.js';
import { readGaussians } from './kept.js';
import { MirroredMesh } from './mirrored_mesh.js';
import { Neighbourhood } from './neighbourhood.js';

const mostFelt = { desk: 50000, headset: 8000 }; // ellipsoids that are drawn
const splatBudget = 500000; // of a headset that draws by itself
const standalone = /Quest|OculusBrowser|Android|Pico|VisionOS/i;
const searched = 4000; // ellipsoids around the tool, of which the nearest is looked for

async function request(url, signal) {
  const response = await fetch(httpUrl(url), { signal });
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return response;
}

// The scene's bytes as {stream, length, failure()}. What breaks off only ends the stream, and is kept as the failure: Spark
// does not look at a stream that fails, and the worker that waits for its next piece would be lost.
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
        failure = error;
        controller.close();
      }
    },
    cancel: (reason) => reader.cancel(reason),
  });
  return { stream, length, failure: () => failure };
}

export class Splats {
  sceneShown = true;
  knowsFelt = false; // which of the loaded Gaussians can be felt
  group = new Group(); // from the captured frame to the world
  #mesh = null;
  #kept = null;
  #felt = null; // as drawn
  #drawn = new Neighbourhood();
  #around = new Neighbourhood();
  #most = mostFelt.desk;

  /// Centres stay in single precision through all of Spark: halves would drift from what is felt.
  constructor(renderer, onDirty) {
    this.onDirty = onDirty;
    this.spark = new BatchedSpark({ renderer, accumExtSplats: true, onDirty });
    this.spark.layers.set(sceneLayer);
    this.group.matrixAutoUpdate = false;
  }

  /// Rejected if `signal` ends it: what has been loaded so far is let go.
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
    this.#mesh?.dispose();
    this.#mesh?.removeFromParent();
    this.#mesh = mesh;
    this.#kept = readGaussians(mesh);
    this.knowsFelt = false;
    mesh.visible = this.sceneShown;
    mesh.layers.set(sceneLayer);
    this.group.add(mesh);
  }

  /// Asks which of the loaded Gaussians can be felt.
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

  /// Where the program has it.
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

  // A point of the world among the Gaussians as they were captured.
  #local(point) {
    return new Vector3(...point).applyMatrix4(this.group.matrix.clone().invert());
  }

  /// Whether what is drawn is still to be sorted for where it is seen from.
  get isSorting() {
    return this.spark.sorting || this.spark.sortDirty;
  }

  /// To be called when the graphics card has lost what was drawn.
  drawAnew() {
    if (this.#mesh) this.#mesh.needsUpdate = true;
    this.onDirty();
  }

  get keptCount() {
    return this.#kept?.count ?? 0;
  }

  /// The diameters of the ellipsoid of a Gaussian, in the world.
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

  /// Draws the felt ellipsoids nearest to a point of the world, if they are on. Returns whether they are others than before.
  update(point) {
    if (!this.#felt?.visible || !this.#kept) return false;
    if (!this.#drawn.follow(this.#kept, this.#local(point), this.#most)) return false;
    return this.#felt.show(this.#drawn.rows.map((row) => this.#kept.at(row)));
  }

  /// Where what can be felt is nearest to a point of the world: {point, distance} in the world, or null.
  closest(point) {
    if (this.keptCount === 0) return null;
    const local = this.#local(point);
    this.#around.follow(this.#kept, local, searched);
    const found = this.#kept.closest(this.#around.rows, local.toArray());
    if (!found) return null;
    const at = new Vector3(...found.point).applyMatrix4(this.group.matrix);
    return { point: at, distance: at.distanceTo(new Vector3(...point)) };
  }

  /// What is seen along a ray of the world: {point, felt, opacity}, or null where it sees nothing. `felt` says whether it can be felt.
  look(ray) {
    return this.#along(ray, (kept, ...line) => kept.hit(...line));
  }

  /// The same of what can be felt alone: it may lie behind what is cut off.
  lookForFelt(ray) {
    return this.#along(ray, (kept, ...line) => kept.hitKept(...line));
  }

  #along(ray, hit) {
    if (!this.#kept) return null;
    const local = new Ray().copy(ray).applyMatrix4(this.group.matrix.clone().invert());
    const seen = hit(this.#kept, local.origin.toArray(), local.direction.toArray());
    return seen && { ...seen, point: local.at(seen.distance, new Vector3()).applyMatrix4(this.group.matrix) };
  }

  /// How much is seen between two points of the world: an opacity.
  opacityBetween(from, to) {
    const [start, end] = [this.#local(from), this.#local(to)];
    return this.#kept?.opacityBefore(start.toArray(), end.sub(start).toArray(), 1) ?? 0;
  }

  /// Where a ray of the world meets what is seen and can be felt, or null.
  pick(ray) {
    const seen = this.look(ray);
    return seen?.felt ? seen.point : null;
  }

  /// The box of what can be felt, in the world; empty before anything is loaded.
  get box() {
    const box = this.#kept?.box;
    return box ? new Box3(new Vector3(...box.min), new Vector3(...box.max)).applyMatrix4(this.group.matrix) : new Box3();
  }

  /// Fewer splats and ellipsoids for a headset that draws by itself.
  async enterHeadset() {
    this.#most = mostFelt.headset;
    this.#drawn.forget();
    const mesh = this.#mesh;
    if (!standalone.test(navigator.userAgent) || !mesh || mesh.numSplats <= splatBudget) return;
    this.spark.lodSplatCount = splatBudget;
    if (!mesh.extSplats.lodSplats) await mesh.createLodSplats();
    mesh.enableLod = this.#most === mostFelt.headset; // it may have been left meanwhile
  }

  leaveHeadset() {
    this.#most = mostFelt.desk;
    this.#drawn.forget();
    if (this.#mesh) this.#mesh.enableLod = false;
  }
}
