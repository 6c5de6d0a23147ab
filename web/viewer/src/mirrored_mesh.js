// Splat mesh that can be placed with a reflection.
//
// Spark decomposes a matrix into rotation, uniform scale and translation. A reflecting matrix T is therefore split into
// T M, which does not reflect, and M = diag(-1, 1, 1), which is applied to every splat first: a rotation R becomes
// M R M, and view-dependent colours are evaluated from the camera position mapped by M.

import { SplatMesh, SplatTransformer, dyno } from '@sparkjsdev/spark';
import { Matrix4, Vector3, Vector4 } from 'three';

const { DynoVec3, DynoVec4, Gsplat, combineGsplat, dynoBlock, mul, splitGsplat } = dyno;
const reflection = new Matrix4().makeScale(-1, 1, 1);

// M or the identity, as factors of centres and of quaternions x, y, z, w.
class Mirror {
  on = false;
  #centre = new DynoVec3({ value: new Vector3(1, 1, 1) });
  #turn = new DynoVec4({ value: new Vector4(1, 1, 1, 1) });

  set(on) {
    this.on = on;
    this.#centre.value.setX(on ? -1 : 1);
    this.#turn.value.set(1, on ? -1 : 1, on ? -1 : 1, 1);
  }

  get modifier() {
    return dynoBlock({ gsplat: Gsplat }, { gsplat: Gsplat }, ({ gsplat }) => {
      const { center, quaternion } = splitGsplat(gsplat).outputs;
      return { gsplat: combineGsplat({ gsplat, center: mul(center, this.#centre), quaternion: mul(quaternion, this.#turn) }) };
    });
  }
}

// Transform T M, or T if T does not reflect.
class Placement extends SplatTransformer {
  constructor(mirror) {
    super();
    this.mirror = mirror;
  }

  updateFromMatrix(matrix) {
    const mirrored = matrix.determinant() < 0;
    const changed = mirrored !== this.mirror.on;
    this.mirror.set(mirrored);
    return super.updateFromMatrix(mirrored ? matrix.clone().multiply(reflection) : matrix) || changed;
  }
}

// Transform from the view to the captured splats; only the camera position is used.
class Eye extends SplatTransformer {
  constructor(mirror) {
    super();
    this.mirror = mirror;
  }

  updateFromMatrix(matrix) {
    return super.updateFromMatrix(this.mirror.on ? matrix.clone().premultiply(reflection) : matrix);
  }
}

export class MirroredMesh extends SplatMesh {
  constructor(options) {
    super(options);
    const mirror = new Mirror();
    this.objectModifier = mirror.modifier;
    this.context.transform = new Placement(mirror);
    this.context.viewToObject = new Eye(mirror);
  }
}
