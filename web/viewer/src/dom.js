// Small helpers for building the page. Text from outside goes through textContent only.

export const byId = (id) => document.getElementById(id);

export function element(tag, { className, text, attributes } = {}, ...children) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text !== undefined) node.textContent = text;
  for (const [name, value] of Object.entries(attributes ?? {})) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

/// The value of a custom property of the page, such as '--ink', in the theme that is on.
export function themeValue(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/// Calls `redraw` when the theme changes.
export function followTheme(redraw) {
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
}
