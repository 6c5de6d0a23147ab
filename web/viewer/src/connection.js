// The rosbridge connection to the program that served this page. Reconnects automatically.
//
// Every attempt uses a new Ros, so that no message from before an interruption is sent after it: a pose or a `resume`
// must never arrive late. Only an emergency stop is asked for again (emergency_stop.js).

import { Ros, Service, Topic, WebSocketTransportFactory } from 'roslib';

import { rosName } from './address.js';

const firstDelay = 250; // delay before the first retry. Unit: [ms].
const longestDelay = 2000; // Unit: [ms].
const checkPeriod = 500; // period of checks for received messages. Unit: [ms].
const silenceLimit = 6; // checks without a message after which the connection is dead; diagnostics come every 50 ms
const beat = 1000; // period of the timer of calls. Unit: [ms].
const answerLimit = 20; // time limit of a call. Unit: [beats], as a stalled page counts only one beat.

/// Message of `error`: roslib passes both strings and objects.
export const errorText = (error) => error?.message ?? (typeof error === 'string' && error ? error : 'no answer');

export class Connection {
  connected = false;
  #ros = null;
  #subscriptions = [];
  #topics = new Map(); // published topics of this connection, by name
  #pending = new Set(); // reject functions of the pending calls
  #listeners = new Set();
  #delay = firstDelay;
  #silence = 0; // checks since the last message; not a time, as a stalled page neither receives nor checks

  constructor(url) {
    this.url = url;
  }

  /// `onStatus` is called with status messages of the server: {level, msg, id}.
  open(onStatus) {
    this.onStatus = onStatus;
    this.#attempt();
    setInterval(() => this.#checkSilence(), checkPeriod);
  }

  /// Calls `listener` when the connection opens (true) and closes (false).
  onChange(listener) {
    this.#listeners.add(listener);
  }

  /// `name` is passed to rosName(); `rest` are further options of roslib's Topic. Call before `open`.
  subscribe(name, messageType, callback, rest = {}) {
    this.#subscriptions.push({ name, messageType, callback, rest });
  }

  publish(name, messageType, message) {
    if (!this.connected) return;
    if (!this.#topics.has(name)) this.#topics.set(name, this.#topic(name, messageType, { queue_size: 1 }));
    this.#topics.get(name).publish(message);
  }

  /// Calls a service. Resolves to the values of the response; rejects if there is none.
  call(name, serviceType, request = {}) {
    if (!this.connected) return Promise.reject(new Error('Not connected.'));
    const service = new Service({ ros: this.#ros, name: rosName(name), serviceType });
    return new Promise((resolve, reject) => {
      const settle = (finish) => (value) => {
        clearInterval(timer);
        this.#pending.delete(reject);
        finish(value);
      };
      let left = answerLimit;
      const timer = setInterval(() => { if (--left === 0) settle(reject)(new Error(`${name}: no answer`)); }, beat);
      this.#pending.add(reject);
      service.callService(request, settle(resolve), settle((error) => reject(new Error(errorText(error)))));
    });
  }

  /// Calls a service with the response {success, message}. Resolves to the message; rejects without success.
  async ask(name, serviceType, request) {
    const { success, message } = await this.call(name, serviceType, request);
    if (!success) throw new Error(message || `${name} was refused`);
    return message;
  }

  #topic(name, messageType, rest) {
    return new Topic({ ros: this.#ros, name: rosName(name), messageType, reconnect_on_close: false, ...rest });
  }

  #attempt() {
    this.#silence = 0;
    const ros = new Ros({
      transportFactory: async (url) => {
        const transport = await WebSocketTransportFactory(url);
        transport.on('message', (message) => {
          this.#silence = 0;
          if (message.op === 'status') this.onStatus(message);
        });
        return transport;
      },
    });
    this.#ros = ros;
    ros.on('connection', () => {
      if (ros === this.#ros) this.#opened();
      else ros.close(); // was abandoned meanwhile
    });
    ros.on('close', () => this.#closed(ros));
    ros.on('error', () => {}); // a close follows
    ros.connect(this.url).catch(() => this.#closed(ros));
  }

  #opened() {
    this.#delay = firstDelay;
    for (const { name, messageType, callback, rest } of this.#subscriptions) {
      this.#topic(name, messageType, rest).subscribe(callback);
    }
    this.#change(true);
  }

  #closed(ros) {
    if (ros !== this.#ros) return;
    this.#ros = null;
    this.#topics.clear();
    for (const reject of this.#pending) reject(new Error('The connection was lost.'));
    this.#pending.clear();
    this.#change(false);
    setTimeout(() => this.#attempt(), this.#delay);
    this.#delay = Math.min(2 * this.#delay, longestDelay);
  }

  #checkSilence() {
    const ros = this.#ros;
    if (!ros || ++this.#silence <= silenceLimit) return;
    ros.close();
    this.#closed(ros); // at once: the closing handshake of a dead peer would take long
  }

  #change(connected) {
    if (this.connected === connected) return;
    this.connected = connected;
    for (const listener of this.#listeners) listener(connected);
  }
}
