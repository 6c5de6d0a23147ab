// Puts the page together: what the program says goes to the view and the panels, what a person does to the program.

import { webSocketUrl } from './address.js';
import { exposeApi } from './api.js';
import { Connection } from './connection.js';
import { byId } from './dom.js';
import { Drag } from './drag.js';
import { createFeelPanel, createToolPanel } from './feel_panel.js';
import { FeltObjects } from './felt_objects.js';
import { Haptics, play, slidingSpeed } from './haptics.js';
import { Headset, supportedModes } from './headset.js';
import { Hold } from './hold.js';
import { createKeepPanel } from './keep_panel.js';
import { Keys } from './keys.js';
import { Legend } from './legend.js';
import { Live } from './live.js';
import { notify } from './notices.js';
import { Parameters } from './parameters.js';
import { Picker } from './pick.js';
import { createPlacementPanel } from './placement_panel.js';
import { Plots } from './plots.js';
import { Room } from './room.js';
import { SceneLoader } from './scene_loader.js';
import { createShownPanel } from './shown_panel.js';
import { Splats } from './splats.js';
import { StatusBar } from './status_bar.js';
import { View, boxAround } from './view.js';
import { followSheet } from './sheet.js';

const poseTopic = '/palpate/client/measured_cp';

const connection = new Connection(webSocketUrl());
const parameters = new Parameters(connection, notify);
const live = new Live(connection);
const view = new View(byId('view'), byId('canvas'));
const splats = new Splats(view.renderer, () => view.invalidate());
const felt = new FeltObjects();
const hold = new Hold(connection, live);
const room = new Room();
const haptics = new Haptics();
const drag = new Drag(view, hold, felt);
const keys = new Keys(view, hold, felt);
const picker = new Picker(view, splats, hold, () => notify('There is nothing to feel at that point.'));
const statusBar = new StatusBar({ connection, live, parameters, hold });

view.add(splats.spark);
view.world.add(splats.group, felt.group, picker.marks);
splats.onMaterial = (object) => view.applyTheme(object);

/// What a person can ask for. Whatever is refused is said.
const asked = (promise) => promise.catch((error) => {
  notify(error.message);
  return null;
});
const actions = {
  stop: () => asked(connection.ask('emergency_stop', 'std_srvs/Trigger')),
  async pauseOrResume() {
    if (parameters.current?.paused) await asked(connection.ask('pause', 'std_srvs/SetBool', { data: false }));
    else if (statusBar.needsResume) await asked(connection.ask('resume', 'std_srvs/Trigger'));
    else await asked(connection.ask('pause', 'std_srvs/SetBool', { data: true }));
  },
  stopOrResume: () => (statusBar.needsResume ? actions.pauseOrResume() : actions.stop()),
  record: (on) => asked(connection.ask('record', 'std_srvs/SetBool', { data: on })),
  config: () => asked(connection.ask('config', 'std_srvs/Trigger')),
  setRoom: (changes) => parameters.set({ room: changes }),
  async loadTool(text, name) {
    if (text === '') notify(`${name} is empty or larger than a tool file may be.`);
    else await asked(connection.ask('load_tool', 'palpate/SetString', { data: text }));
  },
};

const headset = new Headset({
  view, room, hold, splats, actions,
  signText: () => [statusBar.said.text, statusBar.whoHolds, live.force ? `${Math.hypot(...live.force).toFixed(2)} N` : 'no force known'],
});
const { shown, update: updateShown } = createShownPanel({ splats, felt, changed: () => view.invalidate() });
createFeelPanel(parameters);
createToolPanel(parameters, actions.loadTool);
createPlacementPanel(parameters, () => picker.point(), (points) => picker.mark(points));
createKeepPanel(parameters, actions);
const plots = new Plots(connection, live);
const legend = new Legend(view, felt);
const loader = new SceneLoader(splats, () => frameAll());

function frameAll() {
  const box = splats.box;
  const parts = live.tool ? [live.tool.position] : [];
  view.frameAll(box.union(boxAround(parts, 2 * felt.size)));
}

let shownMessage = '';
let knownRoom = '';
parameters.onChange((p) => {
  felt.follow(p);
  loader.follow(p);
  document.title = `${p.scene.name} · Palpate`;
  byId('scene-name').textContent = p.busy ? `${p.scene.name}: ${p.busy}` : p.scene.name;
  if (p.message && p.message !== shownMessage) notify(p.message, 'message');
  shownMessage = p.message;
  // The room that a person in a headset moves is theirs until they let it go.
  if (JSON.stringify(p.room) !== knownRoom) room.set(p.room);
  knownRoom = JSON.stringify(p.room);
});

byId('frame-all').addEventListener('click', frameAll);
byId('stop').addEventListener('click', actions.stop);
byId('pause').addEventListener('click', actions.pauseOrResume);
window.addEventListener('keydown', ({ key }) => { if (key === 'Escape') actions.stop(); });
byId('hold').addEventListener('click', () => {
  if (hold.holds('keys')) hold.end('keys');
  else if (!hold.begin('keys')) notify('The tool can be held as soon as the program says where it is.');
});
hold.onChange(() => {
  byId('hold').setAttribute('aria-pressed', String(hold.holds('keys')));
  view.orbit.enabled = !hold.active;
});
followSheet();

for (const name of ['measured_cp', 'contacts', 'tool', 'spatial/servo_cf', 'proxy_cp']) live.on(name, () => view.invalidate());

supportedModes().then((modes) => {
  for (const mode of modes) {
    const node = byId(mode === 'immersive-vr' ? 'enter-vr' : 'enter-ar');
    node.hidden = false;
    node.addEventListener('click', () => asked(headset.session ? headset.leave() : headset.enter(mode, document.body)));
  }
});

let wasFresh = false;
view.everyFrame((now) => {
  keys.update(now);
  headset.update();
  hold.publish();
  const pulse = haptics.update({
    force: hold.active ? live.force : null,
    forceMax: parameters.current?.device.force_max ?? 1,
    slidingSpeed: slidingSpeed(live.velocity, live.force),
    now: performance.now(),
  });
  if (pulse) {
    headset.pulse(pulse);
    if (hold.holds('keys') && keys.gamepad) play(keys.gamepad, pulse);
  }
  const fresh = live.isFresh('measured_cp');
  if (fresh !== wasFresh) view.invalidate(); // what has become stale has to be drawn as such
  wasFresh = fresh;
  felt.update(live, shown);
  splats.update(live.tool?.position ?? [0, 0, 0]);
  statusBar.update();
  updateShown();
  plots.update();
  legend.update();
});

connection.open(({ level, msg, id }) => {
  if (id?.startsWith(`publish:${poseTopic}`)) hold.refused();
  else if (level === 'error' || level === 'warning') notify(msg);
});
exposeApi({ connection, live, view, splats, felt, haptics, hold, parameters });
view.applyTheme(view.world);
