// The rosbridge connection to the program that served this page. It comes back by itself.
//
// Every attempt has a Ros of its own, so that nothing said before a break is said again after it: a pose or a
// `resume` must never arrive late.

import { Ros, Service, Topic, WebSocketTransportFactory } from 'roslib';

import { rosName } from './address.js';

const firstDelay = 250; // before another attempt. Unit: [ms].
const longestDelay = 2000; // Unit: [ms].
const checkPeriod = 500; // of whether anything is heard. Unit: [ms].
const silenceLimit = 6; // diagnostics come every 50 ms; what is silent for so many checks is dead
const beat = 1000; // Unit: [ms].
const answerLimit = 20; // of a service. Unit: [beats], of which there is one however long the page stood still.

/// What `error` says about itself, whatever it is: roslib hands on texts and objects.
export const errorText = (error) => error?.message ?? (typeof error === 'string' && error ? error : 'no answer');

export class Connection {
  connected = false;
  #ros = null;
  #subscriptions = [];
  #topics = new Map(); // what is published in this connection
  #pending = new Set(); // rejections of the calls that wait for an answer
  #listeners = new Set();
  #delay = firstDelay;
  #silence = 0; // checks since anything was heard: a page that stands still for a while hears nothing and checks nothing

  constructor(url) {
    this.url = url;
  }

  /// `onStatus` is called with what the server says about a message of ours: {level, msg, id}.
  open(onStatus) {
    this.onStatus = onStatus;
    this.#attempt();
    setInterval(() => this.#checkSilence(), checkPeriod);
  }

  /// Calls `listener` when the connection comes (true) and goes (false).
  onChange(listener) {
    this.#listeners.add(listener);
  }

  /// `name` is below /palpate/, or that of the page's hand; `rest` is what roslib's Topic takes besides. To be called before `open`.
  subscribe(name, messageType, callback, rest = {}) {
    this.#subscriptions.push({ name, messageType, callback, rest });
  }

  publish(name, messageType, message) {
    if (!this.connected) return;
    if (!this.#topics.has(name)) this.#topics.set(name, this.#topic(name, messageType, { queue_size: 1 }));
    this.#topics.get(name).publish(message);
  }

  /// The values of the answer; rejected if there is none.
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

  /// A service whose answer is {success, message}: the message, rejected if it did not succeed.
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
      else ros.close(); // it was given up before
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
    for (const reject of this.#pending) reject(new Error('The connection broke off.'));
    this.#pending.clear();
    this.#change(false);
    setTimeout(() => this.#attempt(), this.#delay);
    this.#delay = Math.min(2 * this.#delay, longestDelay);
  }

  #checkSilence() {
    const ros = this.#ros;
    if (!ros || ++this.#silence <= silenceLimit) return;
    ros.close();
    this.#closed(ros); // a dead peer would let the closing handshake take its time
  }

  #change(connected) {
    if (this.connected === connected) return;
    this.connected = connected;
    for (const listener of this.#listeners) listener(connected);
  }
}
