// Panels: force parameters, and tool.

import { byId, element } from '../../shared/dom.js';
import { button, choiceField, hint, numberField, vectorField } from './fields.js';
import { formatLength } from './format.js';

const slackest = 10; // lower end of the stiffness slider. Unit: [N/m].
const largestTool = 64 * 1024; // largest tool file that the program accepts. Unit: [bytes].

export function createFeelPanel(parameters) {
  const set = (name) => (value) => parameters.set({ [name]: value });
  const setFilter = (name) => (value) => parameters.set({ filter: { [name]: value } });
  const model = choiceField({ label: 'Model', name: 'model' }, set('model'));
  const stiffness = numberField(
    { label: 'Stiffness', unit: 'N/m', name: 'stiffness', min: 0, slide: { min: slackest, max: 5000, log: true } }, set('stiffness'));
  const friction = numberField({ label: 'Friction', name: 'friction', min: 0, slide: { min: 0, max: 1 } }, set('friction'));
  const detail = numberField({ label: 'Detail', unit: 'mm (0 = automatic)', name: 'detail', scale: 1000, min: 0 }, set('detail'));
  const opacity = numberField(
    { label: 'Opacity cut', name: 'opacity_min', min: 0, max: 1, slide: { min: 0, max: 1 } }, setFilter('opacity_min'));
  const sigma = numberField({ label: 'Ellipsoid size', unit: 'σ', name: 'sigma', min: 0, slide: { min: 0.2, max: 3 } }, setFilter('sigma'));
  const iso = hint('');
  const nothing = element('p', { className: 'hint nothing', attributes: { role: 'alert' } });
  const dropped = hint('');
  const keepAll = button('Keep all Gaussians', () => parameters.set({ filter: { max_scale: 0, crop_box: [], crop_sphere: [] } }), { name: 'keep-all' });
  const fields = [model, stiffness, friction, detail, opacity, sigma];
  byId('feel').append(...fields.map((field) => field.node), iso, dropped, keepAll, nothing);
  parameters.onChange((p) => {
    model.show(p.models, p.model);
    stiffness.limit(p.stiffness_max);
    stiffness.show(p.stiffness);
    friction.show(p.friction);
    detail.show(p.detail);
    opacity.show(p.filter.opacity_min);
    sigma.show(p.filter.sigma);
    dropped.textContent = droppedBy(p.filter);
    keepAll.hidden = dropped.textContent === '';
    nothing.textContent = isNothingLeft(p) ? 'No touchable Gaussians: none passes the opacity cut and the filter.' : '';
    iso.textContent = p.filter.iso > 0 ? `Ellipsoids extend to a visible opacity of ${p.filter.iso} (--iso); setting σ overrides this.` : '';
  });
}

// What the filter drops besides faint Gaussians, as a sentence; empty if nothing. Both are in metres of the world.
function droppedBy({ max_scale: largest, crop_box: box, crop_sphere: sphere }) {
  const rules = [box?.length > 0 && 'outside the crop box', sphere?.length > 0 && 'outside the crop sphere', largest > 0 && `larger than ${formatLength(largest)}`];
  const all = rules.filter(Boolean).join(' or ');
  return all && `Gaussians ${all} are dropped.`;
}

// No opacity is above 1; or the program has reported an empty list of Gaussians.
const isNothingLeft = ({ filter, felt }) => filter.opacity_min >= 1 || felt?.count === 0;

/// `loadTool(text, name)` receives a tool file.
export function createToolPanel(parameters, loadTool) {
  const axes = vectorField({ label: 'Semi-axes', unit: 'mm', names: ['a', 'b', 'c'], scale: 1000, name: 'semi_axes' },
    (semiAxes) => parameters.set({ tool: [{ ...parameters.current.tool[0], semi_axes: semiAxes }] }));
  const parts = hint('');
  const file = element('input', { attributes: { type: 'file', accept: '.toml', id: 'tool-file', 'data-field': 'tool_file', hidden: '' } });
  file.addEventListener('change', async () => {
    const [chosen] = file.files;
    if (chosen) await loadTool(chosen.size > largestTool ? '' : await chosen.text(), chosen.name);
    file.value = '';
  });
  byId('tool').append(axes.node, parts, button('Load a tool file…', () => file.click(), { name: 'load-tool' }), file);
  parameters.onChange(({ tool }) => {
    axes.node.hidden = tool.length !== 1;
    if (tool.length === 1) axes.show(tool[0].semi_axes);
    parts.textContent = tool.length === 1 ? '' : `${tool.length} ellipsoids: ${tool.slice(0, 4).map((t) => t.name).join(', ')}${tool.length > 4 ? ', …' : ''}`;
  });
}
