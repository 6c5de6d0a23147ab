// What state the program is in, who holds the tool, and what to do about a fault.

import { byId } from '../../shared/dom.js';

const levels = ['good', 'waiting', 'bad']; // of DiagnosticStatus

function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export class StatusBar {
  constructor({ connection, live, parameters, hold }) {
    Object.assign(this, { connection, live, parameters, hold });
    this.state = byId('state');
    this.holder = byId('holder');
    this.advice = byId('advice');
    this.pause = byId('pause');
  }

  /// Whether the force waits for a resume.
  get needsResume() {
    return Boolean(this.parameters.current?.paused) || (this.live.isFresh('diagnostics') && this.live.diagnostics.level === 2);
  }

  /// {text, level, advice} of what can be said now.
  get said() {
    if (!this.connection.connected) return { text: 'disconnected', level: 'bad', advice: 'No connection to the program; trying again.' };
    if (!this.live.isFresh('diagnostics')) return { text: 'no data', level: 'waiting', advice: '' };
    const { level, values } = this.live.diagnostics;
    const fault = values.fault && values.fault !== 'none' ? values.fault : '';
    const text = fault ? `${values.state}: ${fault}` : String(values.state);
    return { text, level: levels[level] ?? 'bad', advice: fault ? String(values.advice) : '' };
  }

  get whoHolds() {
    if (!this.connection.connected) return '';
    if (this.hold.isRefused) return 'someone else holds the tool';
    if (this.hold.active) return 'you hold the tool';
    if (this.live.diagnostics?.values.held_by === 'client' && !this.hold.justLetGo) return 'someone else holds the tool';
    return this.parameters.current?.device.kind === 'simulated' ? 'the simulated hand explores' : '';
  }

  update() {
    const { text, level, advice } = this.said;
    setText(this.state, text);
    if (this.state.dataset.level !== level) this.state.dataset.level = level;
    setText(this.advice, advice);
    this.advice.hidden = advice === '';
    setText(this.holder, this.whoHolds);
    setText(this.pause, this.needsResume ? 'Resume' : 'Pause');
    this.pause.classList.toggle('primary', this.needsResume);
    document.body.classList.toggle('stale', !this.live.isFresh('measured_cp'));
  }
}
