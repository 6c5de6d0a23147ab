// What the graphics card is to have, and whether that is anything new: what stands still is not drawn again.

/// Puts numbers into a Float32Array from an index on. Returns whether that has changed it.
export function fill(array, at, values) {
  let changed = false;
  for (let k = 0; k < values.length; ++k) {
    const value = Math.fround(values[k]);
    changed ||= array[at + k] !== value;
    array[at + k] = value;
  }
  return changed;
}

/// Returns whether it has not been so before.
export function setVisible(object, on) {
  const changed = object.visible !== on;
  object.visible = on;
  return changed;
}
