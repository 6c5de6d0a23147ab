// Builds the 3D view with its objects and input methods. Throws without WebGL 2.

import { byId } from '../../shared/dom.js';
import { exposeApi } from './api.js';
import { Approach } from './approach.js';
import { DepthCue } from './depth_cue.js';
import { Drag } from './drag.js';
import { FeltObjects } from './felt_objects.js';
import { FirstSize } from './first_size.js';
import { ForceCues } from './force_cues.js';
import { Headset, supportedModes } from './headset.js';
import { Keys } from './keys.js';
import { Legend } from './legend.js';
import { notify } from './notices.js';
import { Picker } from './pick.js';
import { createPlacementPanel } from './placement_panel.js';
import { Room } from './room.js';
import { SceneLoader } from './scene_loader.js';
import { createShownPanel } from './shown_panel.js';
import { followShortcuts } from './shortcuts.js';
import { Splats } from './splats.js';
import { TakeHold } from './take_hold.js';
import { View } from './view.js';

/// `updatePanels` is called before every frame.
export function showWorld({ connection, live, parameters, hold, statusBar, plots, actions, updatePanels }) {
  const view = new View(byId('view'), byId('canvas'));
  const splats = new Splats(view.renderer, () => view.invalidate());
  const felt = new FeltObjects();
  const room = new Room();
  const drag = new Drag(view, hold, felt, splats);
  const keys = new Keys(view, hold, felt);
  const picker = new Picker(view);
  const approach = new Approach({ hold, splats, felt });
  const depth = new DepthCue(splats, felt);
  const takeHold = new TakeHold({ view, splats, felt, live, hold, picker, approach, depth, parameters });
  const headset = new Headset({ view, room, hold, splats, felt, live, actions, statusBar, parameters });
  const cues = new ForceCues({ live, hold, parameters, keys, headset });
  headset.onSound = () => cues.toggleSound();
  const { shown, update: updateShown } = createShownPanel({ splats, felt, changed: () => view.invalidate() });
  createPlacementPanel(parameters, { pickPoint: () => picker.point(), mark: (points) => picker.mark(points), propose: actions.proposeSetup });
  const legend = new Legend(view, felt);
  const size = new FirstSize({ parameters, splats, propose: actions.proposeSetup, onSized: () => {
    takeHold.frameAll();
    headset.sceneChanged();
  } });
  const loader = new SceneLoader(splats, () => {
    takeHold.open();
    headset.sceneChanged();
    size.begin();
  });

  view.add(splats.spark);
  view.world.add(splats.group, felt.group, depth.group, picker.marks);
  splats.onMaterial = (object) => view.applyTheme(object);
  view.onRestored = () => splats.drawAnew();

  let knownRoom = '';
  parameters.onChange((p) => {
    felt.follow(p);
    loader.follow(p);
    size.follow(p);
    // Only a changed room is applied, so that other updates do not interrupt a user who moves the world.
    if (JSON.stringify(p.room) !== knownRoom) room.set(p.room);
    knownRoom = JSON.stringify(p.room);
  });

  byId('hold').addEventListener('click', () => takeHold.toggleKeys());
  followShortcuts({ ...takeHold.shortcuts, m: () => cues.toggleSound() });
  hold.onChange(() => {
    byId('hold').setAttribute('aria-pressed', String(hold.holds('keys')));
    view.orbit.enabled = !hold.active || hold.holds('approach');
  });

  supportedModes().then((modes) => {
    for (const mode of modes) {
      const node = byId(mode === 'immersive-vr' ? 'enter-vr' : 'enter-ar');
      node.hidden = false;
      node.addEventListener('click', () => actions.asked(headset.session ? headset.leave() : headset.enter(mode, document.body)));
    }
  });

  view.everyFrame((now) => {
    keys.update(now);
    approach.update(now);
    headset.update(now);
    hold.publish();
    cues.update();
    felt.pixel = live.tool && !view.renderer.xr.isPresenting ? view.pixelAt(live.tool.position) : 0;
    if (felt.update(live, shown)) view.invalidateFront();
    if (depth.update(live, 1000 * now)) view.invalidateFront();
    if (splats.update(live.tool?.position ?? [0, 0, 0])) view.invalidateFront();
    takeHold.update();
    updatePanels();
    updateShown();
    legend.showHands(live.others);
    legend.update();
  });
  view.applyTheme(view.world);
  exposeApi({ connection, live, view, splats, felt, cues, hold, parameters, depth, headset, plots });
}
