// Puts the page together: what the program says goes to the view and the panels, what a person does to the program.

import { byId, element } from '../../shared/dom.js';
import { webSocketUrl } from './address.js';
import { Connection } from './connection.js';
import { createFeelPanel, createToolPanel } from './feel_panel.js';
import { Hold } from './hold.js';
import { createKeepPanel } from './keep_panel.js';
import { Live } from './live.js';
import { notify } from './notices.js';
import { Parameters } from './parameters.js';
import { Plots } from './plots.js';
import { followSheet } from './sheet.js';
import { StatusBar } from './status_bar.js';
import { showWorld } from './world.js';

const poseTopic = '/palpate/client/measured_cp';
const unseenPeriod = 100; // between updates of the panels where nothing is drawn. Unit: [ms].

const connection = new Connection(webSocketUrl());
const parameters = new Parameters(connection, notify);
const live = new Live(connection);
const hold = new Hold(connection, live);
const statusBar = new StatusBar({ connection, live, parameters, hold });
const plots = new Plots(connection, live);

/// What a person can ask for. Whatever is refused is said.
const asked = (promise) => promise.catch((error) => {
  notify(error.message);
  return null;
});
const actions = {
  asked,
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

createFeelPanel(parameters);
createToolPanel(parameters, actions.loadTool);
createKeepPanel(parameters, actions);
followSheet();

let shownMessage = '';
parameters.onChange((p) => {
  for (const fields of document.querySelectorAll('.fields[inert]')) fields.inert = false; // before, there is nothing to change
  document.title = `${p.scene.name} · Palpate`;
  byId('scene-name').textContent = p.busy ? `${p.scene.name}: ${p.busy}` : p.scene.name;
  if (p.message && p.message !== shownMessage) notify(p.message, 'message');
  shownMessage = p.message;
});

byId('stop').addEventListener('click', actions.stop);
byId('pause').addEventListener('click', actions.pauseOrResume);
window.addEventListener('keydown', ({ key, repeat }) => { if (key === 'Escape' && !repeat) actions.stop(); });

function updatePanels() {
  statusBar.update();
  plots.update();
}

try {
  showWorld({ connection, live, parameters, hold, statusBar, actions, updatePanels });
} catch (error) {
  // The force can still be watched and stopped.
  byId('view').replaceChildren(element('p', { className: 'card missing', text: `The scene cannot be drawn: this needs WebGL 2. ${error.message}` }));
  for (const id of ['frame-all', 'hold']) byId(id).hidden = true;
  setInterval(updatePanels, unseenPeriod);
}

connection.open(({ level, msg, id }) => {
  if (id?.startsWith(`publish:${poseTopic}`)) hold.refused();
  else if (level === 'error' || level === 'warning') notify(msg);
});
