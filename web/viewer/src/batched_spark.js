// Spark with many splats per instance. Spark itself draws one splat per instance; with software rendering, the cost per
// instance was most of a frame.

import { SparkRenderer } from '@sparkjsdev/spark';
import { BufferAttribute, InstancedBufferGeometry } from 'three';

const batch = 1024; // splats per instance: divides a row of Spark's ordering, and its vertex indices fit 16 bits
const corners = [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0];
const triangles = [0, 1, 2, 0, 2, 3];

const slot = `(gl_InstanceID * ${batch} + (gl_VertexID >> 2))`; // index of a splat in back-to-front order

export class BatchedSpark extends SparkRenderer {
  constructor(options) {
    super({ ...options, extraUniforms: { slots: { value: 0 } } });
    const batches = Array.from({ length: batch }, (_, k) => k);
    this.geometry = new InstancedBufferGeometry()
      .setAttribute('position', new BufferAttribute(Float32Array.from(batches.flatMap(() => corners)), 3))
      .setIndex(new BufferAttribute(Uint16Array.from(batches.flatMap((k) => triangles.map((corner) => 4 * k + corner))), 1));
    this.material.vertexShader = this.material.vertexShader
      .replaceAll('gl_InstanceID', slot)
      .replace('void main() {', `uniform int slots;\nvoid main() {\ngl_Position = vec4(0.0, 0.0, 2.0, 1.0);\nif (${slot} >= slots) return;`);
  }

  onBeforeRender(...drawn) {
    super.onBeforeRender(...drawn);
    const { activeSplats } = SparkRenderer.sparkOverride ?? this;
    this.uniforms.slots.value = activeSplats;
    this.geometry.instanceCount = Math.ceil(activeSplats / batch);
  }
}
