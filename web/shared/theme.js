// Colours of the page: custom properties of its style sheet.

/// Value of a custom property, such as '--ink', in the current theme.
export function themeValue(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/// Calls `redraw` when the theme changes.
export function followTheme(redraw) {
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
}

/// Sets the materials below `root` to the colour named by their `userData.color`, in the current theme.
export function applyTheme(root) {
  root.traverse(({ material }) => {
    if (material?.userData.color) material.color.set(themeValue(material.userData.color));
  });
}
