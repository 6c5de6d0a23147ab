// The scene and the tool in 3D, and the tool in the hand. Needs WebGL 2: throws where there is none.

import { byId } from '../../shared/dom.js';
import { exposeApi } from './api.js';
import { Drag } from './drag.js';
import { FeltObjects } from './felt_objects.js';
import { Haptics, play, slidingSpeed } from './haptics.js';
import { Headset, supportedModes } from './headset.js';
import { Keys } from './keys.js';
import { Legend } from './legend.js';
import { notify } from './notices.js';
import { Picker } from './pick.js';
import { createPlacementPanel } from './placement_panel.js';
import { Room } from './room.js';
import { SceneLoader } from './scene_loader.js';
import { createShownPanel } from './shown_panel.js';
import { Splats } from './splats.js';
import { View, boxAround } from './view.js';

/// `updatePanels` is called before every frame.
export function showWorld({ connection, live, parameters, hold, statusBar, actions, updatePanels }) {
  const view = new View(byId('view'), byId('canvas'));
  const splats = new Splats(view.renderer, () => view.invalidate());
  const felt = new FeltObjects();
  const room = new Room();
  const haptics = new Haptics();
  const drag = new Drag(view, hold, felt);
  const keys = new Keys(view, hold, felt);
  const picker = new Picker(view, splats, () => notify('There is nothing to feel at that point.'));
  const headset = new Headset({
    view, room, hold, splats, actions,
    signText: () => [statusBar.said.text, statusBar.whoHolds, live.force ? `${Math.hypot(...live.force).toFixed(2)} N` : 'no force known'],
  });
  const { shown, update: updateShown } = createShownPanel({ splats, felt, changed: () => view.invalidate() });
  createPlacementPanel(parameters, () => picker.point(), (points) => picker.mark(points));
  const legend = new Legend(view, felt);
  const loader = new SceneLoader(splats, () => frameAll());

  view.add(splats.spark);
  view.world.add(splats.group, felt.group, picker.marks);
  splats.onMaterial = (object) => view.applyTheme(object);
  view.onRestored = () => splats.drawAnew();

  function frameAll() {
    const box = splats.box;
    const parts = live.tool ? [live.tool.position] : [];
    view.frameAll(box.union(boxAround(parts, 2 * felt.size)));
  }

  let knownRoom = '';
  parameters.onChange((p) => {
    felt.follow(p);
    loader.follow(p);
    // The room that a person in a headset moves is theirs until they let it go.
    if (JSON.stringify(p.room) !== knownRoom) room.set(p.room);
    knownRoom = JSON.stringify(p.room);
  });

  byId('frame-all').addEventListener('click', frameAll);
  byId('hold').addEventListener('click', () => {
    if (hold.holds('keys')) hold.end('keys');
    else if (!hold.begin('keys')) notify('The tool can be held as soon as the program says where it is.');
  });
  hold.onChange(() => {
    byId('hold').setAttribute('aria-pressed', String(hold.holds('keys')));
    view.orbit.enabled = !hold.active;
  });

  supportedModes().then((modes) => {
    for (const mode of modes) {
      const node = byId(mode === 'immersive-vr' ? 'enter-vr' : 'enter-ar');
      node.hidden = false;
      node.addEventListener('click', () => actions.asked(headset.session ? headset.leave() : headset.enter(mode, document.body)));
    }
  });

  function playForce() {
    const pulse = haptics.update({
      force: hold.active ? live.force : null,
      forceMax: parameters.current?.device.force_max ?? 1,
      slidingSpeed: slidingSpeed(live.velocity, live.force),
      now: performance.now(),
    });
    if (!pulse) return;
    headset.pulse(pulse);
    if (hold.holds('keys') && keys.gamepad) play(keys.gamepad, pulse);
  }

  view.everyFrame((now) => {
    keys.update(now);
    headset.update();
    hold.publish();
    playForce();
    if (felt.update(live, shown)) view.invalidate();
    splats.update(live.tool?.position ?? [0, 0, 0]);
    updatePanels();
    updateShown();
    legend.update();
  });
  view.applyTheme(view.world);
  exposeApi({ connection, live, view, splats, felt, haptics, hold, parameters });
}
