// Panel: registration of the captured scene in the world.

import { Euler, Quaternion } from 'three';

import { byId, element } from '../../shared/dom.js';
import { button, hint, numberField, setPressed, vectorField } from './fields.js';
import { formatLength } from './format.js';
import { createSetup } from './setup_proposal.js';

const degree = Math.PI / 180;
const scales = { min: 0.001, max: 100 }; // range of the slider. Unit: [m] per captured unit.

// Angles of rotations about the world's x, then y, then z axis. Unit: [rad].
const anglesOf = ([w, x, y, z]) => new Euler().setFromQuaternion(new Quaternion(x, y, z, w), 'ZYX').toArray().slice(0, 3);

function rotationOf(angles) {
  const { x, y, z, w } = new Quaternion().setFromEuler(new Euler(...angles, 'ZYX'));
  return [w, x, y, z];
}

/// `pickPoint` resolves to a clicked point of the world, or null; `propose` to a setup as JSON, or null.
export function createPlacementPanel(parameters, { pickPoint, mark, propose }) {
  const set = (changes) => parameters.set({ registration: changes });
  const scale = numberField(
    { label: 'Scale', unit: 'm per captured unit', name: 'scale', min: 0, slide: { ...scales, log: true } }, (value) => set({ scale: value }));
  const translation = vectorField({ label: 'Translation', unit: 'm', names: ['x', 'y', 'z'], name: 'translation' }, (value) => set({ translation: value }));
  const rotation = vectorField({ label: 'Rotation', unit: '° about x, y, z', names: ['x', 'y', 'z'], scale: 1 / degree, name: 'rotation' },
    (value) => set({ rotation: rotationOf(value) }));
  const frames = element('div', { className: 'buttons', attributes: { role: 'group', 'aria-label': 'Captured axis that points up' } });
  const mirrored = button('Mirrored', () => set({ mirrored: !parameters.current.registration.mirrored }), { name: 'mirrored' });
  mirrored.title = 'Reverse the x axis of the capture, for files written by left-handed tools';
  const measured = createMeasure({ pickPoint, mark, onLength: (has, is) => set({ scale: (parameters.current.registration.scale * is) / has }) });

  const setup = createSetup({ propose, apply: (changes) => parameters.set(changes) });

  byId('placement').append(setup, element('p', { className: 'label', text: 'Up axis' }), frames, element('div', { className: 'buttons' }, mirrored),
    measured, scale.node, translation.node, rotation.node);
  let shownFrames = '';
  parameters.onChange(({ registration, frames: names }) => {
    if (names.join() !== shownFrames) { // rebuilt only on a change, to keep the focus
      frames.replaceChildren(...names.map((frame) => button(frame, () => set({ frame }), { name: `frame-${frame}` })));
      shownFrames = names.join();
    }
    names.forEach((frame, k) => setPressed(frames.children[k], frame === registration.frame));
    setPressed(mirrored, Boolean(registration.mirrored));
    scale.show(registration.scale);
    translation.show(registration.translation);
    rotation.show(anglesOf(registration.rotation));
  });
}

// Metric scale from two points and their true distance.
function createMeasure({ pickPoint, mark, onLength }) {
  const said = hint('');
  said.setAttribute('role', 'status');
  let length = null;
  let runs = 0; // a restarted measurement cancels the previous one
  const show = (points, text) => {
    mark(points);
    said.textContent = text;
  };
  const start = button('Measure two points', async () => {
    const run = ++runs;
    const points = [];
    truth.node.hidden = true;
    for (const which of ['first', 'second']) {
      show(points, `Click the ${which} point.`);
      const point = await pickPoint();
      if (run !== runs) return;
      if (!point) {
        show([], '');
        return;
      }
      points.push(point);
    }
    length = points[0].distanceTo(points[1]);
    show(points, `Measured: ${formatLength(length)}. Enter the actual distance:`);
    truth.node.hidden = !(length > 0);
    truth.node.querySelector('input').focus();
  }, { name: 'measure' });
  const truth = numberField({ label: 'Actual distance', unit: 'mm', scale: 1000, min: 0, name: 'true_distance' }, (is) => {
    if (!(is > 0)) return;
    onLength(length, is);
    truth.node.hidden = true;
    show([], '');
  });
  truth.node.hidden = true;
  return element('div', { className: 'fields' }, start, said, truth.node);
}
