// Text and buttons of the panel in the room.

import { formatFixed } from './format.js';

const stiffer = 1.25; // factor on the stiffness per press
const legendForce = 1; // force of the legend. Unit: [N].
const millisecond = 1e-3;

/// `headset` has {statusBar, live, frames, felt, room}.
export function roomPanelContent({ statusBar, live, frames, felt, room }) {
  const { text, level } = statusBar.said;
  const force = live.force ? `${formatFixed(Math.hypot(...live.force), 2)} N` : 'unknown';
  return {
    lines: [
      statusBar.unconfirmed || statusBar.stop || text, statusBar.whoHolds, `Force ${force}`,
      `Frame ${formatFixed(frames.mean / millisecond, 1)} ms, longest ${formatFixed(frames.longest / millisecond, 0)} ms`,
      `${statusBar.parameters.current?.model ?? ''}, ${formatFixed(statusBar.parameters.current?.stiffness, 0)} N/m`,
    ],
    level, legend: { newtons: legendForce, centimetres: formatFixed(100 * felt.forceLength * legendForce / room.scale, 1) },
  };
}

/// Buttons of the panel. `headset` calls `press` when one is pointed at and selected.
export function roomPanelButtons(headset) {
  const { actions, parameters } = headset;
  const set = (changes) => parameters.set(changes);
  const scaled = (by) => () => set({ stiffness: Math.min(parameters.current.stiffness * by, parameters.current.stiffness_max) });
  const nextModel = () => {
    const { models, model } = parameters.current;
    set({ model: models[(models.indexOf(model) + 1) % models.length] });
  };
  const fixed = (text) => () => text;
  return [
    { name: 'stop', label: fixed('Emergency stop'), press: () => actions.stop() },
    { name: 'resume', label: fixed('Resume'), press: () => actions.resume() },
    { name: 'softer', label: fixed('Softer'), press: scaled(1 / stiffer) },
    { name: 'stiffer', label: fixed('Stiffer'), press: scaled(stiffer) },
    { name: 'model', label: () => `Model: ${parameters.current?.model ?? ''}`, press: nextModel },
    { name: 'demo', label: () => (parameters.current?.demo ? 'Stop demo' : 'Start demo'), press: () => actions.toggleDemo() },
    { name: 'sound', label: fixed('Sound'), press: () => headset.onSound?.() },
    { name: 'recentre', label: fixed('Recentre'), press: () => headset.recentre() },
    { name: 'leave', label: fixed('Leave'), press: () => headset.leave() },
  ];
}
