// Reference client of Palpate's gateway: makes something with motors the device of `palpate run --device client`.
//
// One module without dependencies, for browsers and for Node 20 or later. A Node that has no global WebSocket (before
// 22) gets one from the package ws: `new PalpateClient({ forceMax: 8, WebSocket: (await import('ws')).WebSocket })`.
//
//     import { PalpateClient } from './palpate_client.mjs';
//     const client = new PalpateClient({ forceMax: 8, torqueMax: 0 });
//     await client.connect('ws://127.0.0.1:9090/'); // with a token: ws://HOST:PORT/?token=TOKEN
//     // 60 to 1000 times a second:
//     client.send({ position: [0, 0, 0.1], orientation: [1, 0, 0, 0] });
//     motors.show(client.wrench.force);
//
// The program refuses pages that it has not served itself; such a page reaches it through a proxy of its own server.
//
// What a client must do is listed in docs/gateway.md; palpate_client.h is the same in C++. SI units; quaternions are
// w, x, y, z; poses of the handle and wrenches on it are in the device's own right-handed frame.

const topics = {
  pose: '/palpate/client/measured_cp',
  wrench: '/palpate/client/servo_cf',
  echo: '/palpate/client/echo',
  echoed: '/palpate/client/echoed',
};

const none = () => ({ force: [0, 0, 0], torque: [0, 0, 0] });
const norm = (v) => Math.hypot(...v);
const scaled = (v, factor) => v.map((x) => x * factor);
const clamped = (v, most) => (norm(v) > most ? scaled(v, most / norm(v)) : v);
const isVector = (v) => v.length === 3 && v.every(Number.isFinite);

/// Stands between the wrenches that come over the network and the motors. What show() returns is
///
///  - finite, and within the limits: a larger wrench is scaled down in its direction;
///  - zero before the first wrench, and from `silence` on after the pose that the last wrench answers was measured;
///  - zero from `fall` after the call that first sees a wrench that is not finite, a message that is none, or the loss of
///    the connection;
///  - after any of these, or after show() itself was not called for `silence`, zero until a wrench is small (`gate`), and
///    then a share that rises from zero to one within `rise`.
///
/// A drop is a straight line and not a step; the line begins early enough to end at `silence`. Has no clock: all times are
/// arguments, in seconds on one clock that never falls.
export class WrenchGovernor {
  static silence = 0.05; // s
  static fall = 0.005; // s
  static rise = 0.1; // s
  static gate = 0.05; // share of forceMax and of torqueMax

  #limits;
  #heard = { ...none(), t: -Infinity, good: false, breaks: 0 };
  #state = 'closed'; // or 'open', 'falling'
  #breaks = 0;
  #shownAt = -Infinity;
  #since = 0;
  #fallEnd = 0;
  #shown = none();
  #fallsFrom = none();

  /// The largest that the device may show, in N (above 0) and N m (0 without motors for the orientation).
  constructor({ forceMax, torqueMax = 0 }) {
    if (!(Number.isFinite(forceMax) && forceMax > 0)) throw new RangeError('forceMax must be above 0 N');
    if (!(Number.isFinite(torqueMax) && torqueMax >= 0)) throw new RangeError('torqueMax must be 0 N m or more');
    this.#limits = { forceMax, torqueMax };
  }

  /// A wrench came at `t`, as the answer to a pose that was measured at `measuredAt`.
  take({ force, torque }, measuredAt, t) {
    if (!isVector(force) || !isVector(torque)) {
      this.fail();
      return;
    }
    if (!(t - measuredAt <= WrenchGovernor.silence)) return; // also where it answers none
    const breaks = this.#heard.breaks + (t - this.#heard.t > WrenchGovernor.silence ? 1 : 0);
    const { forceMax, torqueMax } = this.#limits;
    this.#heard = {
      force: clamped(force, forceMax), torque: clamped(torque, torqueMax), t: Math.min(measuredAt, t), good: true, breaks,
    };
  }

  /// Something came that is no wrench, or the connection is lost.
  fail() {
    this.#heard = { ...this.#heard, good: false, breaks: this.#heard.breaks + 1 };
  }

  /// What the motors shall show at `now`.
  show(now) {
    const { silence, fall } = WrenchGovernor;
    const heard = this.#heard;
    const zeroAt = heard.t + silence;
    const lost = !heard.good || heard.breaks !== this.#breaks || now > zeroAt - fall || now - this.#shownAt > silence;
    this.#breaks = heard.breaks;
    this.#shownAt = now;
    if (this.#state === 'open' && lost) {
      this.#enter('falling', now);
      this.#fallEnd = Math.min(now + fall, zeroAt);
      this.#fallsFrom = this.#shown;
    }
    if (this.#state === 'falling' && now >= this.#fallEnd) this.#enter('closed', now);
    if (this.#state === 'closed' && !lost && this.#isSmall(heard)) this.#enter('open', now);
    this.#shown = this.#inThisState(now);
    return this.#shown;
  }

  #enter(state, now) {
    this.#state = state;
    this.#since = now;
  }

  #isSmall({ force, torque }) {
    const { forceMax, torqueMax } = this.#limits;
    return norm(force) <= WrenchGovernor.gate * forceMax && norm(torque) <= WrenchGovernor.gate * torqueMax;
  }

  #inThisState(now) {
    if (this.#state === 'closed') return none();
    const [whole, share] = this.#state === 'open'
      ? [this.#heard, Math.min(1, (now - this.#since) / WrenchGovernor.rise)]
      : [this.#fallsFrom, (this.#fallEnd - now) / (this.#fallEnd - this.#since)];
    return { force: scaled(whole.force, share), torque: scaled(whole.torque, share) };
  }
}

const stampOf = (t) => {
  const nanoseconds = Math.round(1e9 * t);
  return { secs: Math.floor(nanoseconds / 1e9), nsecs: nanoseconds % 1e9 };
};
const vectorOf = (value) => [value?.x, value?.y, value?.z];

/// A connection to a running program. Events: 'status' (detail: what the program tells this client, for a person) and
/// 'close'. Where it is lost, nothing but connect() makes another.
export class PalpateClient extends EventTarget {
  #WebSocket;
  #governor;
  #socket = null;
  #waiting = null; // the newest pose, while what was sent before is still here
  #wrenchCount = 0;

  /// `WebSocket` is a constructor as in browsers.
  constructor({ forceMax, torqueMax = 0, WebSocket = globalThis.WebSocket }) {
    super();
    if (typeof WebSocket !== 'function') throw new TypeError('there is no WebSocket here; give the constructor of ws');
    this.#WebSocket = WebSocket;
    this.#governor = new WrenchGovernor({ forceMax, torqueMax });
  }

  /// The clock that poses are stamped with and echoes are answered with: monotonic, in s.
  static now() {
    return performance.now() / 1000;
  }

  /// Rejects where the program does not answer or does not want this client.
  async connect(url) {
    this.disconnect();
    this.#waiting = null; // what was measured before is not sent
    const socket = new this.#WebSocket(url);
    this.#socket = socket;
    socket.addEventListener('message', ({ data }) => { if (socket === this.#socket) this.#hear(data); });
    await new Promise((done, failed) => {
      socket.addEventListener('open', done);
      socket.addEventListener('error', () => {}); // 'close' follows
      socket.addEventListener('close', () => {
        if (socket === this.#socket) this.#lose();
        failed(new Error(`${new URL(url).host}: there is no connection`));
      });
    });
    for (const topic of [topics.wrench, topics.echo]) socket.send(JSON.stringify({ op: 'subscribe', topic }));
  }

  /// The force falls to zero.
  disconnect() {
    const socket = this.#socket;
    if (socket === null) return;
    this.#lose();
    socket.close();
  }

  /// Whether the connection is there; a program that hangs still has one.
  get isConnected() {
    return this.#socket !== null && this.#socket.readyState === 1;
  }

  /// What the motors shall show now, as { force: [x, y, z], torque: [x, y, z] }: see WrenchGovernor. To be asked at least
  /// every 50 ms.
  get wrench() {
    return this.#governor.show(PalpateClient.now());
  }

  /// How many wrenches have come so far.
  get wrenchCount() {
    return this.#wrenchCount;
  }

  /// The pose of the handle, { position: [x, y, z], orientation: [w, x, y, z] }, measured at that time of now(). It replaces
  /// one that is not sent yet.
  send(pose, measuredAt = PalpateClient.now()) {
    this.#waiting = { pose, measuredAt };
    this.#sendWaiting();
  }

  #sendWaiting() {
    if (this.#waiting === null || !this.isConnected || this.#socket.bufferedAmount > 0) return;
    const { pose: { position: p, orientation: q }, measuredAt } = this.#waiting;
    this.#waiting = null;
    this.#publish(topics.pose, {
      header: { stamp: stampOf(measuredAt), frame_id: 'device' },
      pose: { position: { x: p[0], y: p[1], z: p[2] }, orientation: { w: q[0], x: q[1], y: q[2], z: q[3] } },
    });
  }

  #publish(topic, msg) {
    this.#socket.send(JSON.stringify({ op: 'publish', topic, msg }));
  }

  #lose() {
    this.#socket = null;
    this.#governor.fail();
    this.dispatchEvent(new Event('close'));
  }

  #hear(data) {
    const t = PalpateClient.now();
    let message = null;
    try {
      message = JSON.parse(data);
    } catch {
      // as null
    }
    if (message?.op === 'status') this.dispatchEvent(new CustomEvent('status', { detail: String(message.msg) }));
    else if (message?.op === 'publish' && message.topic === topics.echo) this.#answer(message.msg?.seq, t);
    else if (message?.op === 'publish' && message.topic === topics.wrench) this.#take(message.msg, t);
    else this.#governor.fail();
    this.#sendWaiting();
  }

  #answer(seq, t) {
    if (!Number.isSafeInteger(seq) || seq < 0) this.#governor.fail();
    else this.#publish(topics.echoed, { seq, stamp: stampOf(t), frame_id: '' });
  }

  #take(message, t) {
    const stamp = message?.header?.stamp;
    const wrench = { force: vectorOf(message?.wrench?.force), torque: vectorOf(message?.wrench?.torque) };
    this.#governor.take(wrench, stamp?.secs + stamp?.nsecs / 1e9, t);
    this.#wrenchCount += 1;
  }
}
