import { element } from '../../shared/dom.js';

/// A symbol with a subscript, as in t_a.
export function symbol(base, subscript) {
  const node = element('span', { className: 'symbol', text: base });
  if (subscript) node.append(element('sub', { text: subscript }));
  return node;
}
