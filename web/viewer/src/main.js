// Builds the page and connects it: messages of the program to the view and the panels, user input to the program.

import { byId, element } from '../../shared/dom.js';
import { createActions } from './actions.js';
import { rosName, webSocketUrl } from './address.js';
import { Connection } from './connection.js';
import { EmergencyStop } from './emergency_stop.js';
import { followEscape } from './escape.js';
import { createFeelPanel, createToolPanel } from './feel_panel.js';
import { Hold } from './hold.js';
import { createKeepPanel } from './keep_panel.js';
import { createKeysDialog } from './keys_dialog.js';
import { Live } from './live.js';
import { createMessagesPanel } from './messages_panel.js';
import { notify } from './notices.js';
import { Parameters } from './parameters.js';
import { Plots } from './plots.js';
import { createScenesDialog } from './scenes_dialog.js';
import { followSheet } from './sheet.js';
import { followShortcuts } from './shortcuts.js';
import { StatusBar } from './status_bar.js';
import { refuseUnknownHand } from './unknown_hand.js';
import { showWorld } from './world.js';

const poseTopic = rosName('client/measured_cp');
const unseenPeriod = 100; // interval of panel updates without a 3D view. Unit: [ms].
const drawn = ['frame-all', 'find', 'hold', 'sound']; // ids of controls that need the 3D view

const connection = new Connection(webSocketUrl());
const parameters = new Parameters(connection, notify);
const live = new Live(connection);
const hold = new Hold(connection, live);
const emergencyStop = new EmergencyStop(connection);
const statusBar = new StatusBar({ connection, live, parameters, hold, emergencyStop });
const plots = new Plots(connection, live);
const actions = createActions({ connection, parameters, statusBar, hold, emergencyStop });

refuseUnknownHand(connection);
createFeelPanel(parameters);
createToolPanel(parameters, actions.loadTool);
createKeepPanel(parameters, actions);
createMessagesPanel(connection);
followSheet();

let shownMessage = '';
parameters.onChange((p) => {
  for (const fields of document.querySelectorAll('.fields[inert]')) fields.inert = false; // had no parameters before
  byId('hand-name').textContent = p.hand && `hand ${p.hand}`;
  byId('hand-name').hidden = !p.hand;
  byId('scene-name').textContent = p.busy ? `${p.scene.name}: ${p.busy}` : p.scene.name;
  if (p.message && p.message !== shownMessage) notify(p.message, 'message');
  shownMessage = p.message;
});

byId('stop').addEventListener('click', actions.stop);
byId('pause').addEventListener('click', actions.pauseOrResume);
byId('resume').addEventListener('click', actions.resume);
byId('demo').addEventListener('click', actions.toggleDemo);
followEscape(actions.stop);
const openScenes = createScenesDialog({ list: actions.listScenes, open: actions.openScene, parameters });
followShortcuts({ '?': createKeysDialog(), o: openScenes, p: actions.pauseOrResume, g: actions.toggleDemo });

function updatePanels() {
  statusBar.update();
  plots.update();
}

try {
  showWorld({ connection, live, parameters, hold, statusBar, plots, actions, updatePanels });
} catch (error) {
  // Without the view, the force can still be monitored and stopped.
  byId('view').replaceChildren(element('p', { className: 'card missing', text: `The scene cannot be drawn: this needs WebGL 2. ${error.message}` }));
  for (const id of drawn) byId(id).hidden = true;
  setInterval(updatePanels, unseenPeriod);
}

connection.open(({ level, msg, id }) => {
  if (id?.startsWith(`publish:${poseTopic}`)) hold.refused();
  else if (level === 'error' || level === 'warning') notify(msg);
});
