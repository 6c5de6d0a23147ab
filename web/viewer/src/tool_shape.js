// Shape of a tool: ellipsoids {semi_axes, position, orientation: [w, x, y, z]} around its handle.

import { Quaternion, Vector3 } from 'three';

/// Size of a tool: about its largest extent from the handle, at least 0.1 mm. Unit: [m].
export function toolSize(parts) {
  const reach = ({ semi_axes: s, position: p }) => Math.hypot(...p) + Math.hypot(...s) / Math.sqrt(3);
  return Math.max(1e-4, ...parts.map(reach));
}

/// Extent of a tool from its handle in a world direction, for the orientation `handle`, a Quaternion.
export function reachOf(parts, handle, direction) {
  const along = direction.clone().normalize().applyQuaternion(handle.clone().invert());
  return Math.max(0, ...parts.map(({ semi_axes: s, position: p, orientation: [w, x, y, z] }) => {
    const local = along.clone().applyQuaternion(new Quaternion(x, y, z, w).invert());
    return along.dot(new Vector3(...p)) + Math.hypot(s[0] * local.x, s[1] * local.y, s[2] * local.z);
  }));
}
