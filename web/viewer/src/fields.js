// Controls of the panels. Each shows the program's value and requests the value that the user enters.

import { element } from '../../shared/dom.js';
import { formatField } from './format.js';
import { notify } from './notices.js';

let lastId = 0;
const newId = (name) => `${name.toLowerCase().replace(/[^a-z0-9]+/g, '-')}-${++lastId}`;

function row(label, id, unit, ...controls) {
  const name = element('label', { text: label, attributes: { for: id } });
  if (unit) name.append(' ', element('span', { className: 'unit', text: unit }));
  return element('div', { className: 'field' }, name, element('div', { className: 'controls' }, ...controls));
}

// The typed number; null, with a notice, if it is invalid.
function typedNumber(input, label) {
  if (input.value !== '' && input.checkValidity()) return Number(input.value);
  notify(`${label}: ${input.validationMessage || 'this must be a number.'}`);
  return null;
}

/// Number field, with a slider if `slide` is given: {min, max, log}. `scale` is the factor from the program's unit to
/// the displayed one. With `onRelease` the slider takes effect when released. Returns {node, show(value), limit(most)}.
export function numberField({ label, unit, scale = 1, min, max, slide, name, onRelease = false }, wanted) {
  const id = newId(label);
  const input = element('input', { attributes: { type: 'number', id, step: 'any', 'data-field': name, inputmode: 'decimal' } });
  if (min !== undefined) input.min = min;
  if (max !== undefined) input.max = max;
  const slider = slide ? element('input', { attributes: { type: 'range', min: 0, max: 1000, 'aria-label': label } }) : null;
  const toShare = (v) => (slide.log ? Math.log(v / slide.min) / Math.log(slide.max / slide.min) : (v - slide.min) / (slide.max - slide.min));
  const fromShare = (s) => (slide.log ? slide.min * (slide.max / slide.min) ** s : slide.min + s * (slide.max - slide.min));
  let current = null;
  let typing = false; // show() must not replace text being typed,
  let sliding = false; // nor move a slider being dragged

  input.addEventListener('input', () => { typing = true; });
  input.addEventListener('blur', () => {
    typing = false;
    show(current);
  });
  input.addEventListener('change', () => {
    typing = false;
    const typed = typedNumber(input, label);
    if (typed === null) show(current);
    else wanted(typed / scale);
  });
  const slid = () => Number(fromShare(slider.value / 1000).toPrecision(3));
  slider?.addEventListener('input', () => {
    sliding = true;
    if (onRelease) input.value = formatField(slid());
    else wanted(slid() / scale);
  });
  slider?.addEventListener('change', () => {
    sliding = false;
    if (onRelease) wanted(slid() / scale);
  });

  function show(value) {
    current = value;
    if (value === null) return;
    const shown = value * scale;
    if (!typing) input.value = formatField(shown);
    if (!slider) return;
    if (!sliding) slider.value = 1000 * Math.min(Math.max(toShare(shown), 0), 1);
    slider.setAttribute('aria-valuetext', [formatField(shown), unit ?? ''].join(' ').trim());
  }
  return {
    node: row(label, id, unit, ...(slider ? [slider] : []), input),
    show,
    limit(most) { if (slide) slide.max = most; input.max = most; },
  };
}

/// Selection field. Returns {node, show(options, chosen)}.
export function choiceField({ label, name }, wanted) {
  const id = newId(label);
  const select = element('select', { attributes: { id, 'data-field': name } });
  select.addEventListener('change', () => wanted(select.value));
  return {
    node: row(label, id, '', select),
    show(options, chosen) {
      const same = options.length === select.length && options.every((o, i) => o === select.options[i].value);
      if (!same) select.replaceChildren(...options.map((text) => element('option', { text })));
      select.value = chosen;
    },
  };
}

export function checkbox({ label, checked = true, name }, changed) {
  const box = element('input', { attributes: { type: 'checkbox', 'data-toggle': name } });
  box.checked = checked;
  box.addEventListener('change', () => changed(box.checked));
  return element('label', { className: 'check' }, box, element('span', { text: label }));
}

export function button(label, pressed, { name } = {}) {
  const node = element('button', { text: label, attributes: { type: 'button', ...(name ? { 'data-action': name } : {}) } });
  node.addEventListener('click', pressed);
  return node;
}

export const setPressed = (node, on) => node.setAttribute('aria-pressed', String(on));

/// Three numbers side by side. Returns {node, show(values)}; `wanted` receives all three.
export function vectorField({ label, unit, names, scale = 1, name }, wanted) {
  const inputs = names.map((axis, k) => element('input', {
    attributes: { type: 'number', step: 'any', 'aria-label': `${label}, ${axis}`, 'data-field': `${name}-${k}`, inputmode: 'decimal' },
  }));
  let current = null;
  let typing = null; // the input being typed in
  const change = () => {
    typing = null;
    const typed = inputs.map((input, k) => typedNumber(input, `${label}, ${names[k]}`));
    if (typed.includes(null)) show(current);
    else wanted(typed.map((value) => value / scale));
  };
  for (const input of inputs) {
    input.addEventListener('input', () => { typing = input; });
    input.addEventListener('change', change);
    input.addEventListener('blur', () => {
      typing = null;
      show(current);
    });
  }
  function show(values) {
    current = values;
    values?.forEach((value, k) => {
      if (inputs[k] !== typing) inputs[k].value = formatField(value * scale);
    });
  }
  const legend = element('legend', { text: label }, ' ', element('span', { className: 'unit', text: unit }));
  return { node: element('fieldset', { className: 'vector' }, legend, element('div', { className: 'controls' }, ...inputs)), show };
}

export const hint = (text) => element('p', { className: 'hint', text });
