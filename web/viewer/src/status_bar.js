// Status bar: state of the program, holder of the tool, and advice on faults.

import { byId } from '../../shared/dom.js';

const levels = ['good', 'waiting', 'bad']; // by level of DiagnosticStatus
const unexplained = 1000; // time without force before an explanation is shown. Unit: [ms].
const lift = { text: 'waiting: lift the tool', level: 'waiting', advice: 'the force returns once the tool touches nothing' };

function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export class StatusBar {
  #waitsSince = null; // time since which the force waits for the tool to be lifted. Unit: [ms].

  constructor({ connection, live, parameters, hold, emergencyStop }) {
    Object.assign(this, { connection, live, parameters, hold, emergencyStop });
    this.state = byId('state');
    this.holder = byId('holder');
    this.advice = byId('advice');
    this.pause = byId('pause');
    this.demo = byId('demo');
    this.stopped = byId('stopped');
  }

  /// Whether the force waits for a resume.
  get needsResume() {
    return Boolean(this.parameters.current?.paused) || (this.live.isFresh('diagnostics') && this.live.diagnostics.level === 2);
  }

  /// Current status: {text, level, advice}.
  get said() {
    if (!this.connection.connected) return { text: 'disconnected', level: 'bad', advice: 'No connection to the program; retrying' };
    if (!this.live.isFresh('diagnostics')) return { text: 'no data', level: 'waiting', advice: '' };
    const { level, values } = this.live.diagnostics;
    const fault = values.fault && values.fault !== 'none' ? values.fault : '';
    if (this.#waitsLong) return lift;
    const text = fault ? `${values.state}: ${fault}` : String(values.state);
    return { text, level: levels[level] ?? 'bad', advice: fault ? String(values.advice) : '' };
  }

  get #waitsLong() {
    return this.#waitsSince !== null && performance.now() - this.#waitsSince > unexplained;
  }

  // Detects that there is no force without a fault: after a stop, the tool may be inside a surface.
  #watch() {
    const { fault, state } = (this.live.isFresh('diagnostics') && this.live.diagnostics.values) || {};
    if (state !== 'waiting' || (fault && fault !== 'none')) this.#waitsSince = null;
    else this.#waitsSince ??= performance.now();
  }

  get whoHolds() {
    if (!this.connection.connected) return '';
    if (this.hold.isRefused) return 'someone else holds the tool';
    if (this.hold.active) return 'you hold the tool';
    if (this.live.diagnostics?.values.held_by === 'client' && !this.hold.justLetGo) return 'someone else holds the tool';
    const { demo } = this.parameters.current ?? {};
    return demo === undefined ? '' : demo ? 'demo: the simulated hand explores' : 'the tool stays where it is';
  }

  /// Reason why there is no force until a resume; empty if there is none.
  get stop() {
    return this.needsResume ? `No force: ${this.said.text.replace(/^\w+: /, '')}.` : '';
  }

  /// That the force may be on although the user has stopped it; empty if not.
  get unconfirmed() {
    return this.emergencyStop.isUnconfirmed ? 'Stop not confirmed; repeating it.' : '';
  }

  #title(stop) {
    const { scene, hand } = this.parameters.current ?? {};
    const title = [stop && 'Stopped', hand && `hand ${hand}`, scene?.name, 'Palpate'].filter(Boolean).join(' · ');
    if (document.title !== title) document.title = title;
  }

  update() {
    this.#watch();
    const { text, level, advice } = this.said;
    setText(this.state, text);
    if (this.state.dataset.level !== level) this.state.dataset.level = level;
    const { stop, unconfirmed } = this;
    setText(this.advice, [unconfirmed, stop, advice && `${advice[0].toUpperCase()}${advice.slice(1)}.`].filter(Boolean).join(' '));
    this.stopped.hidden = advice === '' && stop === '' && unconfirmed === '';
    this.stopped.dataset.level = stop === '' && unconfirmed === '' ? level : 'bad';
    byId('resume').hidden = stop === '';
    document.body.classList.toggle('stopped-force', stop !== '');
    this.#title(stop);
    setText(this.holder, this.whoHolds);
    setText(this.pause, this.needsResume ? 'Resume' : 'Pause');
    this.pause.classList.toggle('primary', this.needsResume);
    const { demo } = this.parameters.current ?? {};
    this.demo.hidden = demo === undefined;
    setText(this.demo, demo ? 'Stop demo' : 'Start demo');
    document.body.classList.toggle('stale', !this.live.isFresh('measured_cp'));
  }
}
