// Cached image of the scene behind everything else: splats are slow to draw, and usually only the tool moves. Splats
// and other objects do not occlude each other, so that the objects can be drawn over the image.

import { BufferAttribute, BufferGeometry, FramebufferTexture, GLSL3, Mesh, NoBlending, ShaderMaterial, Vector2 } from 'three';

export const sceneLayer = 3; // three.js layer of the cached objects; 1 and 2 are the eyes of a headset

const everywhere = new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3); // a triangle

export class Backdrop {
  #material = new ShaderMaterial({
    glslVersion: GLSL3,
    uniforms: { picture: { value: null } },
    vertexShader: 'void main() { gl_Position = vec4(position, 1.0); }',
    fragmentShader: `
      uniform sampler2D picture;
      out vec4 color;
      void main() { color = texelFetch(picture, ivec2(gl_FragCoord.xy), 0); }`,
    depthTest: false, depthWrite: false, blending: NoBlending,
  });
  #mesh = new Mesh(new BufferGeometry().setAttribute('position', everywhere), this.#material);

  constructor(renderer, scene) {
    Object.assign(this, { renderer, scene });
    this.#mesh.frustumCulled = false;
    this.#mesh.renderOrder = -1;
    scene.add(this.#mesh);
  }

  /// Draws everything; the scene itself only if it `changed`.
  draw(camera, changed) {
    if (changed) this.#take(camera);
    this.#mesh.visible = true;
    camera.layers.disable(sceneLayer);
    this.renderer.render(this.scene, camera);
    this.#mesh.visible = false;
    camera.layers.enable(sceneLayer);
  }

  #take(camera) {
    const size = this.renderer.getDrawingBufferSize(new Vector2());
    const { picture } = this.#material.uniforms;
    if (picture.value?.image.width !== size.x || picture.value.image.height !== size.y) {
      picture.value?.dispose();
      picture.value = new FramebufferTexture(size.x, size.y);
    }
    const before = camera.layers.mask;
    camera.layers.set(sceneLayer);
    this.renderer.render(this.scene, camera);
    camera.layers.mask = before;
    this.renderer.copyFramebufferToTexture(picture.value);
  }
}
