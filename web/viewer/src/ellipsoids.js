// Many ellipsoids in one draw call.

import {
  Color, DynamicDrawUsage, IcosahedronGeometry, InstancedBufferAttribute, InstancedMesh, Matrix4, MeshLambertMaterial, Quaternion,
  ShaderMaterial, Vector3,
} from 'three';

import { fill } from './fill.js';

const matrix = new Matrix4();
const position = new Vector3();
const rotation = new Quaternion();
const size = new Vector3();
const color = new Color();

// Shells have an opaque rim and a translucent middle, so that they show their shape without hiding what they touch.
const vertexShader = `
  varying vec3 seenNormal;
  varying vec3 seenPosition;
  void main() {
    mat3 axes = mat3(instanceMatrix);
    // The normal of a stretched sphere is stretched by the inverse.
    vec3 turned = axes * (normal / vec3(dot(axes[0], axes[0]), dot(axes[1], axes[1]), dot(axes[2], axes[2])));
    seenNormal = normalMatrix * turned;
    vec4 seen = modelViewMatrix * instanceMatrix * vec4(position, 1.0);
    seenPosition = seen.xyz;
    gl_Position = projectionMatrix * seen;
  }`;
const fragmentShader = `
  uniform vec3 color;
  uniform float fill;
  uniform float rim;
  varying vec3 seenNormal;
  varying vec3 seenPosition;
  void main() {
    vec3 n = normalize(seenNormal);
    float facing = abs(dot(n, normalize(seenPosition)));
    float light = 0.72 + 0.28 * n.y;
    gl_FragColor = vec4(color * light, mix(fill, rim, pow(1.0 - facing, 2.0)));
    #include <colorspace_fragment>
  }`;

/// Translucent material. `fill` and `rim` are the opacities of its middle and its edge; `options` are a material's.
export function shellMaterial(colorName, fill, rim, options = {}) {
  const material = new ShaderMaterial({
    vertexShader, fragmentShader, transparent: true, depthWrite: false,
    uniforms: { color: { value: new Color() }, fill: { value: fill }, rim: { value: rim } },
    ...options,
  });
  material.color = material.uniforms.color.value;
  material.userData.color = colorName;
  return material;
}

/// Opaque, lit material. It is declared transparent to be drawn after the splats, which are transparent.
export function solidMaterial(options = {}) {
  return new MeshLambertMaterial({ transparent: true, ...options });
}

export class Ellipsoids extends InstancedMesh {
  /// `detail` is the number of subdivisions of an icosahedron.
  constructor(capacity, material, { order, detail = 4 }) {
    super(new IcosahedronGeometry(1, detail), material, capacity);
    this.instanceMatrix.setUsage(DynamicDrawUsage);
    this.frustumCulled = false;
    this.renderOrder = order;
    this.count = 0;
  }

  /// Shows `list` of {position, orientation: [x, y, z, w], semiAxes, color}, where `color` is optional [r, g, b] in
  /// sRGB. Returns whether anything changed.
  show(list) {
    const count = Math.min(list.length, this.instanceMatrix.count);
    let changed = count !== this.count;
    this.count = count;
    for (let i = 0; i < count; ++i) {
      const { position: p, orientation, semiAxes, color: rgb } = list[i];
      matrix.compose(position.set(...p), rotation.set(...orientation).normalize(), size.set(...semiAxes));
      changed = fill(this.instanceMatrix.array, 16 * i, matrix.elements) || changed;
      if (rgb) changed = this.#setColor(i, color.setRGB(...rgb).convertSRGBToLinear()) || changed;
    }
    if (!changed) return false;
    this.instanceMatrix.needsUpdate = true;
    this.boundingSphere = null; // cached by three.js for its raycaster
    if (this.instanceColor) this.instanceColor.needsUpdate = true;
    return true;
  }

  #setColor(i, { r, g, b }) {
    this.instanceColor ??= new InstancedBufferAttribute(new Float32Array(3 * this.instanceMatrix.count).fill(1), 3);
    return fill(this.instanceColor.array, 3 * i, [r, g, b]);
  }

  /// Centre of a drawn instance, in the frame of the mesh.
  centre(index) {
    this.getMatrixAt(index, matrix);
    return new Vector3().setFromMatrixPosition(matrix).toArray();
  }
}
