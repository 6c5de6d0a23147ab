// Updates of graphics data that report changes, so that nothing is redrawn without one.

/// Writes numbers to a Float32Array from index `at`. Returns whether it changed.
export function fill(array, at, values) {
  let changed = false;
  for (let k = 0; k < values.length; ++k) {
    const value = Math.fround(values[k]);
    changed ||= array[at + k] !== value;
    array[at + k] = value;
  }
  return changed;
}

/// Shows or hides an object. Returns whether that changed.
export function setVisible(object, on) {
  const changed = object.visible !== on;
  object.visible = on;
  return changed;
}
