// Splats that are drawn right where they are placed with a reflection, too.
//
// Spark takes a rotation, a uniform scale and a translation out of a matrix. One that reflects, T, is therefore split
// into T M, which does not, and M = diag(-1, 1, 1), which is applied to every splat before: a turn R becomes M R M, and
// colours that depend on the direction are those seen from where M takes the eye.

import { SplatMesh, SplatTransformer, dyno } from '@sparkjsdev/spark';
import { Matrix4, Vector3, Vector4 } from 'three';

const { DynoVec3, DynoVec4, Gsplat, combineGsplat, dynoBlock, mul, splitGsplat } = dyno;
const reflection = new Matrix4().makeScale(-1, 1, 1);

// M or the identity, as factors of a centre and of a quaternion x, y, z, w.
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

// T M, or T if it does not reflect.
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

// Where the eye is among the splats as they were captured; only its position is used.
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
