// Small helpers for building the page. Text from the run goes through textContent only.

export function element(tag, { className, text, attributes } = {}, ...children) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text !== undefined) node.textContent = text;
  for (const [name, value] of Object.entries(attributes ?? {})) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

/// A symbol with a subscript, as in t_a.
export function symbol(base, subscript) {
  const node = element('span', { className: 'symbol', text: base });
  if (subscript) node.append(element('sub', { text: subscript }));
  return node;
}

/// The value of a custom property of the page, such as '--ink', in the theme that is on.
export function themeValue(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
