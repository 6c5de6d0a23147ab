// The colours of the page, which are custom properties of its style sheet.

/// The value of a custom property, such as '--ink', in the theme that is on.
export function themeValue(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/// Calls `redraw` when the theme changes.
export function followTheme(redraw) {
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
}

/// Gives materials below `root` the colour that their `userData.color` names, in the theme that is on.
export function applyTheme(root) {
  root.traverse(({ material }) => {
    if (material?.userData.color) material.color.set(themeValue(material.userData.color));
  });
}
