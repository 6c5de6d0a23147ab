// Panel: where the captured scene is in the world, and how large.

import { Euler, Quaternion } from 'three';

import { byId, element } from './dom.js';
import { button, hint, numberField, vectorField } from './fields.js';
import { formatLength } from './format.js';

const degree = Math.PI / 180;

// Turns about x, then y, then z of the world. Unit: [rad].
const anglesOf = ([w, x, y, z]) => new Euler().setFromQuaternion(new Quaternion(x, y, z, w), 'ZYX').toArray().slice(0, 3);

function rotationOf(angles) {
  const { x, y, z, w } = new Quaternion().setFromEuler(new Euler(...angles, 'ZYX'));
  return [w, x, y, z];
}

/// `pickPoint` promises a point of the world that a person clicks, or null.
export function createPlacementPanel(parameters, pickPoint, mark) {
  const registration = () => parameters.current.registration;
  const set = (changes) => {
    const { scale, rotation, translation, frame } = registration();
    parameters.set({ registration: { frame, scale, rotation, translation, ...changes } });
  };

  const scale = numberField({ label: 'Scale', unit: 'm per captured unit', name: 'scale', min: 0 }, (value) => set({ scale: value }));
  const translation = vectorField({ label: 'Translation', unit: 'm', names: ['x', 'y', 'z'], name: 'translation' }, (value) => set({ translation: value }));
  const rotation = vectorField({ label: 'Rotation', unit: '° about x, y, z', names: ['x', 'y', 'z'], scale: 1 / degree, name: 'rotation' },
    (value) => set({ rotation: rotationOf(value) }));
  const frames = element('div', { className: 'buttons', attributes: { role: 'group', 'aria-label': 'Which captured axis points up' } });
  const measured = createMeasure({ pickPoint, mark, onLength: (has, is) => set({ scale: (registration().scale * is) / has }) });

  byId('placement').append(element('p', { className: 'label', text: 'Upright' }), frames, measured, scale.node, translation.node, rotation.node);
  parameters.onChange((p) => {
    frames.replaceChildren(...p.frames.map((frame) => {
      const node = button(frame, () => set({ frame }), { name: `frame-${frame}` });
      node.setAttribute('aria-pressed', String(frame === p.registration.frame));
      return node;
    }));
    scale.show(p.registration.scale);
    translation.show(p.registration.translation);
    rotation.show(anglesOf(p.registration.rotation));
  });
}

// The metric scale from two points and their true distance.
function createMeasure({ pickPoint, mark, onLength }) {
  const said = hint('');
  let length = null;
  const start = button('Measure two points', async () => {
    said.textContent = 'Click the first point.';
    mark([]);
    const first = await pickPoint();
    if (!first) return finish('');
    mark([first]);
    said.textContent = 'Click the second point.';
    const second = await pickPoint();
    if (!second) return finish('');
    mark([first, second]);
    length = first.distanceTo(second);
    finish(`They are ${formatLength(length)} apart as it is. Their true distance:`);
    truth.node.hidden = !(length > 0);
    return undefined;
  }, { name: 'measure' });
  const truth = numberField({ label: 'True distance', unit: 'mm', scale: 1000, min: 0, name: 'true_distance' }, (is) => {
    if (!(is > 0)) return;
    onLength(length, is);
    truth.node.hidden = true;
    finish('');
    mark([]);
  });
  truth.node.hidden = true;
  const finish = (text) => { said.textContent = text; };
  return element('div', { className: 'fields' }, start, said, truth.node);
}
