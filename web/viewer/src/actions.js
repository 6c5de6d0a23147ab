// Requests of the user to the program. Refusals are shown as notices.

import { notify } from './notices.js';

export function createActions({ connection, parameters, statusBar, hold, emergencyStop }) {
  const asked = (promise) => promise.catch((error) => {
    notify(error.message);
    return null;
  });
  const ask = (...request) => asked(connection.ask(...request));
  const pause = (on) => ask('pause', 'std_srvs/SetBool', { data: on });
  const actions = {
    asked,
    stop: () => emergencyStop.press(),
    async resume() {
      const presses = emergencyStop.presses;
      const done = await (parameters.current?.paused ? pause(false) : ask('resume', 'std_srvs/Trigger'));
      if (done !== null) emergencyStop.forget(presses);
    },
    pauseOrResume: () => (statusBar.needsResume ? actions.resume() : pause(true)),
    toggleDemo() {
      hold.endAll(); // only the simulated hand may hold the tool then
      return ask('demo', 'std_srvs/SetBool', { data: !parameters.current?.demo });
    },
    record: (on) => ask('record', 'std_srvs/SetBool', { data: on }),
    config: () => ask('config', 'std_srvs/Trigger'),
    listScenes: () => ask('list_scenes', 'std_srvs/Trigger'),
    openScene: (id) => ask('open_scene', 'palpate/SetString', { data: id }),
    proposeSetup: () => ask('propose_setup', 'std_srvs/Trigger'),
    setRoom: (changes) => parameters.set({ room: changes }),
    async loadTool(text, name) {
      if (text === '') notify(`${name} is empty or too large for a tool file.`);
      else await ask('load_tool', 'palpate/SetString', { data: text });
    },
  };
  return actions;
}
