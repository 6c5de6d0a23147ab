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
// Over a link that takes a millisecond or more each way, with the damping of the device and the hand that holds it in
// N s/m, the force is made here, of the program's local model, 1000 times a second:
//
//     const client = new PalpateClient({ forceMax: 8, damping: 2 });
//     motors.show(client.wrenchAt(position).force); // and client.send() of the same position
//
// Called every 4 ms, as by a page's timers at best, 500 N/m are as firm; what is stiffer than 2 damping / 4 ms, 1000 N/m
// here, comes and goes. The reports of the device itself are a better clock.
//
// The program refuses pages that it has not served itself; such a page reaches it through a proxy of its own server.
//
// What a client must do is listed in docs/gateway.md; palpate_client.h is the same in C++. SI units; quaternions are
// w, x, y, z; poses of the handle and wrenches on it are in the device's own right-handed frame.

const topics = {
  pose: '/palpate/client/measured_cp',
  wrench: '/palpate/client/servo_cf',
  localModel: '/palpate/client/local_model',
  echo: '/palpate/client/echo',
  echoed: '/palpate/client/echoed',
};

const none = () => ({ force: [0, 0, 0], torque: [0, 0, 0] });
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const norm = (v) => Math.hypot(v[0], v[1], v[2]);
const scaled = (v, factor) => [v[0] * factor, v[1] * factor, v[2] * factor];
/// a + factor b.
const sum = (a, b, factor = 1) => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
const clamped = (v, most) => {
  const length = norm(v);
  return length > most ? scaled(v, most / length) : v;
};
const isVector = (v) => v?.length === 3 && [0, 1, 2].every((k) => Number.isFinite(v[k]));

/// Whether it is a place: finite, and near enough that nothing made of it overflows. In m.
const isPlace = (v) => isVector(v) && norm(v) <= 1e6;

const mostPlanes = 4;

/// Whether a local model that has come may be rendered. It is the surface about the handle, as palpate/LocalModel of
/// docs/gateway.md has it, in the device's frame:
///
///     position   of the handle that it was made for, [x, y, z] in m
///     planes     at most 4 of { point, normal }, that the handle stays before: [x, y, z] in m, and unit, outward
///     stiffness  N/m; 0: there is no local model, and the wrench is shown
///     damping    N s/m
///     friction   Coulomb's coefficient
///     share      of the force that the program lets through now, in [0, 1]
export function isGood({ position, planes, stiffness, damping, friction, share }) {
  const amount = (x) => Number.isFinite(x) && x >= 0;
  const unit = 1e-3;
  return isPlace(position) && amount(stiffness) && amount(damping) && amount(friction) && amount(share) && share <= 1
    && Array.isArray(planes) && planes.length <= mostPlanes
    && planes.every(({ point, normal }) => isPlace(point) && isVector(normal) && Math.abs(norm(normal) - 1) <= unit);
}

const noModel = { position: [0, 0, 0], planes: [], stiffness: 0, damping: 0, friction: 0, share: 0 };

/// The nearest place before all planes on the way `from` a place `to` another: Gauss-Seidel sweeps over pushes and drags,
/// each projected on what planes and friction can do, as constrained_motion() of the program.
function nearest({ planes, friction }, from, to) {
  const sweeps = 32; // four planes that form a corner settle in ten
  let motion = sum(to, from, -1);
  const pushes = planes.map(() => 0);
  const drags = planes.map(() => [0, 0, 0]);
  const gaps = planes.map(({ point, normal }) => dot(normal, sum(from, point, -1)));
  for (let sweep = 0; sweep < sweeps; sweep += 1) {
    for (let k = 0; k < planes.length; k += 1) {
      const { normal } = planes[k];
      const step = Math.max(-pushes[k], -(gaps[k] + dot(normal, motion)));
      pushes[k] += step;
      motion = sum(motion, normal, step);
      const slip = sum(motion, normal, -dot(normal, motion));
      const drag = clamped(sum(drags[k], slip, -1), friction * pushes[k]);
      motion = sum(motion, sum(drag, drags[k], -1));
      drags[k] = drag;
    }
  }
  return sum(from, motion);
}

/// Makes the force of a local model at the rate of the device, in place of one that is as late as the network is. A spring
/// of the model's stiffness leads from the handle to a proxy: the nearest place before all planes on the way from where the
/// proxy was, with friction (god-object, Zilles and Salisbury 1995), as ProxyForce of the program has it.
///
/// Passive whatever planes come and however they differ from those before. With F the force that was shown since the last
/// call, d the way of the handle since then, dt the time but no less than T = `period`, and b the damping of device and hand,
///
///     E' = E - F . d + b d^2 / dt           what the hand has put in, and what the device has absorbed
///     |F'| <= 2 sqrt(b E' / T)              so that (F' - 2 b d / T)^2 >= 0 leaves E'' >= 0, whatever d is
///     E  = min(E', max(k L^2 / 2, F'^2 T / 4 b))
///
/// where L is the length of the spring. Of that length, f = min(L, sqrt(2 E' / k)) is felt: a plane that comes towards the
/// handle winds up nothing, and what is missing comes as the hand moves. A plane alone is felt in full if k <= 2 b / T
/// (Colgate and Schenkel 1997); a stiffer model is rendered with that. The sum of F . d is thus never more than that of
/// b d^2 / dt, which the device absorbs, but for what a call later than T makes of a plane stiffer than 2 b / dt; that is a
/// debt, and no force is shown until it is paid.
///
/// Positions are taken as measured: a device that counts in coarse steps moves less than b d^2 / dt says.
export class LocalRenderer {
  static period = 1e-3; // s, between calls, at most
  static slewTime = 0.01; // s, from no force to all, however often called
  static gap = 0.05; // s, between calls, after which it begins anew
  static jump = 0.05; // m, that no hand makes between calls
  static #velocityFilter = 0.005; // s

  #forceMax;
  #damping;
  // Of the last call: m, m/s, s.
  #position = [0, 0, 0];
  #proxy = [0, 0, 0];
  #velocity = [0, 0, 0];
  #t = -Infinity;
  #shown = [0, 0, 0]; // N
  #energy = 0; // J
  #stored = 0; // J, that the whole spring holds
  #pressed = 0; // N

  /// `damping` is the least viscous damping of the device and the hand that holds it, in N s/m, above 0.
  constructor({ forceMax, damping }) {
    this.#forceMax = forceMax;
    this.#damping = damping;
  }

  /// The force in N at `position`, [x, y, z] in m, at the time `now` in s: no more than `most`. Wants a model that isGood().
  ask(model, position, now) {
    const { period, slewTime, gap, jump } = LocalRenderer;
    if (!isPlace(position) || !(now - this.#t <= gap) || norm(sum(position, this.#position, -1)) > jump) {
      this.#restart(position, now);
      return [0, 0, 0];
    }
    const way = sum(position, this.#position, -1);
    const passed = Math.max(0, now - this.#t);
    const dt = Math.max(passed, period);
    this.#energy += this.#damping * dot(way, way) / dt - dot(this.#shown, way);
    const change = sum(scaled(way, 1 / dt), this.#velocity, -1);
    this.#velocity = sum(this.#velocity, change, -Math.expm1(-dt / LocalRenderer.#velocityFilter));
    this.#position = [...position];
    this.#t = now;
    this.#proxy = nearest(model, this.#proxy, position);
    const pull = sum(this.#proxy, position, -1);
    const length = norm(pull);
    const k = Math.min(model.stiffness * model.share, 2 * this.#damping / period);
    this.#stored = 0.5 * k * length * length;
    this.#pressed = model.stiffness * length;
    const wanted = length > 0 ? this.#spring(model, pull, k) : [0, 0, 0];
    const step = clamped(sum(wanted, this.#shown, -1), this.#forceMax * passed / slewTime);
    return clamped(sum(this.#shown, step), this.most);
  }

  /// What is shown from now on, of what was asked for: no more than `most`, in N.
  show(force) {
    this.#shown = [...force];
    this.#energy = Math.min(this.#energy,
      Math.max(this.#stored, dot(force, force) * LocalRenderer.period / (4 * this.#damping)));
  }

  /// The largest force that has the energy behind it, in N.
  get most() {
    return 2 * Math.sqrt(this.#damping * Math.max(0, this.#energy) / LocalRenderer.period);
  }

  /// That the whole of the spring would show, however stiff, in N.
  get pressed() {
    return this.#pressed;
  }

  /// E, in J; below zero a debt.
  get energy() {
    return this.#energy;
  }

  /// Forgets all but a debt.
  reset() {
    this.#restart([0, 0, 0], -Infinity);
  }

  #restart(position, now) {
    const known = isPlace(position);
    this.#position = known ? [...position] : [0, 0, 0];
    this.#proxy = this.#position;
    this.#t = known ? now : -Infinity;
    this.#velocity = [0, 0, 0];
    this.#shown = [0, 0, 0];
    this.#stored = 0;
    this.#pressed = 0;
    this.#energy = Math.min(0, this.#energy);
  }

  /// What is felt of the spring, with the model's damping: at most twice as much, and never a pull.
  #spring(model, pull, k) {
    const length = norm(pull);
    const force = Math.min(k * length, Math.sqrt(2 * k * Math.max(0, this.#energy)));
    const outward = dot(this.#velocity, pull) / length;
    const damped = force - Math.min(model.damping, this.#damping) * model.share * outward;
    return scaled(pull, Math.min(Math.max(damped, 0), 2 * force) / length);
  }
}

/// Where a force begins and ends. After a loss it falls to zero along a straight line, since a step is felt as a knock and
/// excites the device; it is zero until what is asked for is small, and then a share of it that rises from zero to one.
class ForceGate {
  static silence = 0.05; // s
  static fall = 0.005; // s
  static rise = 0.1; // s

  #state = 'closed'; // or 'open', 'falling'
  #passedAt = -Infinity;
  #since = 0;
  #fallEnd = 0;
  #passed = none();
  #fallsFrom = none();

  /// `small`: what is asked for may open it. `broken`: zero within `fall`. `zeroAt`: nothing is left from then on, in s. Not
  /// being called for `silence` closes it at once: by then a watchdog may have switched the motors off, and a line that begins
  /// at the force before would be a step for the hand. So does a clock that was set back.
  pass(asked, { small, broken, zeroAt, now }) {
    const { silence, fall } = ForceGate;
    const stalled = !(now >= this.#passedAt && now - this.#passedAt <= silence);
    const lost = broken || now > zeroAt - fall || stalled;
    this.#passedAt = now;
    if (stalled) this.#enter('closed', now);
    if (this.#state === 'open' && lost) {
      this.#enter('falling', now);
      this.#fallEnd = Math.min(now + fall, zeroAt);
      this.#fallsFrom = this.#passed;
    }
    if (this.#state === 'falling' && now >= this.#fallEnd) this.#enter('closed', now);
    if (this.#state === 'closed' && !lost && small) this.#enter('open', now);
    this.#passed = this.#inThisState(asked, now);
    return { force: [...this.#passed.force], torque: [...this.#passed.torque] };
  }

  #enter(state, now) {
    this.#state = state;
    this.#since = now;
  }

  #inThisState(asked, now) {
    if (this.#state === 'closed') return none();
    const [whole, share] = this.#state === 'open'
      ? [asked, Math.min(1, (now - this.#since) / ForceGate.rise)]
      : [this.#fallsFrom, (this.#fallEnd - now) / (this.#fallEnd - this.#since)];
    return { force: scaled(whole.force, share), torque: scaled(whole.torque, share) };
  }
}

/// Stands between what comes over the network and the motors. What show() returns is
///
///  - finite, and within the limits: a larger wrench is scaled down in its direction;
///  - zero before the first wrench, and from `silence` on after the pose that the last wrench answers was measured;
///  - zero from `fall` after the call that first sees a wrench that is not finite, a message that is none, or the loss of
///    the connection;
///  - zero in the first call after show() itself was not called for `silence`;
///  - after any of these, zero until a wrench is small (`gate`), and then a share that rises from zero to one within `rise`.
///
/// A drop is a straight line and not a step; the line begins early enough to end at `silence`.
///
/// Where local models come, and `damping` is known, the force of showAt() is that of LocalRenderer, and the torque that of
/// the last wrench. A force that is made here is not late, and planes are right for longer than forces: it is zero from
/// `silence` on after the last model came, from `modelAge` on after the pose was measured that that answers, and `fall` after
/// the handle is farther than `near` from there, or nowhere. All else is as above. Where models begin or cease to have a
/// stiffness, as the force model of the program is changed, the force of the one source falls within `fall`, and that of the
/// other comes: of the wrench in LocalRenderer.slewTime, of the local model through its gate.
///
/// Has no clock: all times are arguments, in seconds on one clock that never falls.
export class WrenchGovernor {
  static silence = ForceGate.silence; // s
  static fall = ForceGate.fall; // s
  static rise = ForceGate.rise; // s
  static gate = 0.05; // share of forceMax and of torqueMax
  static modelAge = 0.1; // s
  static near = 0.01; // m, over which a ball of 0.1 m is flat to half a millimetre

  #limits;
  #heard = { ...none(), t: -Infinity, good: false, breaks: 0 };
  #heardModel = { model: noModel, measuredAt: -Infinity, came: -Infinity, good: false, breaks: 0 };
  #gate = new ForceGate();
  #modelGate = new ForceGate();
  #renderer;
  #breaks = 0;
  #modelBreaks = 0;
  #remoteShare = 1;
  #sharedAt = -Infinity; // s

  /// The largest that the device may show, in N (above 0) and N m (0 without motors for the orientation); and the least
  /// viscous damping of the device and the hand that holds it, in N s/m: above 0 local models are rendered, no stiffer than it
  /// keeps passive.
  constructor({ forceMax, torqueMax = 0, damping = 0 }) {
    if (!(Number.isFinite(forceMax) && forceMax > 0)) throw new RangeError('forceMax must be above 0 N');
    if (!(Number.isFinite(torqueMax) && torqueMax >= 0)) throw new RangeError('torqueMax must be 0 N m or more');
    if (!(Number.isFinite(damping) && damping >= 0)) throw new RangeError('damping must be 0 N s/m or more');
    this.#limits = { forceMax, torqueMax, damping };
    this.#renderer = new LocalRenderer({ forceMax, damping });
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

  /// A local model, likewise: see isGood().
  takeModel(model, measuredAt, t) {
    if (!isGood(model)) {
      this.fail();
      return;
    }
    if (!(t - measuredAt <= WrenchGovernor.modelAge)) return;
    const breaks = this.#heardModel.breaks + (t > this.#modelZeroAt() ? 1 : 0);
    this.#heardModel = { model, measuredAt: Math.min(measuredAt, t), came: t, good: true, breaks };
  }

  /// Something came that is no wrench, or the connection is lost.
  fail() {
    this.#heard = { ...this.#heard, good: false, breaks: this.#heard.breaks + 1 };
    this.#heardModel = { ...this.#heardModel, good: false, breaks: this.#heardModel.breaks + 1 };
  }

  /// What the motors shall show at `now`, of the wrenches alone.
  show(now) {
    const heard = this.#heard;
    const broken = !heard.good || heard.breaks !== this.#breaks;
    this.#breaks = heard.breaks;
    const small = this.#isSmall(norm(heard.force)) && norm(heard.torque) <= WrenchGovernor.gate * this.#limits.torqueMax;
    return this.#gate.pass(heard, { small, broken, zeroAt: heard.t + WrenchGovernor.silence, now });
  }

  /// What the motors shall show at `now` with the handle at `position`, in m.
  showAt(position, now) {
    const shown = this.show(now);
    const { model, good, breaks } = this.#heardModel;
    if (this.#limits.damping === 0) return shown;
    const local = model.stiffness > 0;
    const isNear = isPlace(position) && norm(sum(position, model.position, -1)) <= WrenchGovernor.near;
    const broken = !good || breaks !== this.#modelBreaks || !isNear || !local;
    this.#modelBreaks = breaks;
    const asked = clamped(this.#renderer.ask(model, position, now), this.#limits.forceMax);
    // Without a share the program feels nothing, and a model has no planes though the handle may be pressed.
    const small = model.share > 0 && this.#isSmall(this.#renderer.pressed);
    const passed = this.#modelGate.pass({ ...none(), force: asked }, { small, broken, zeroAt: this.#modelZeroAt(), now });
    const made = clamped(passed.force, this.#renderer.most);
    this.#renderer.show(made);
    const force = clamped(sum(made, shown.force, this.#nextRemoteShare(local, now)), this.#limits.forceMax);
    return { force, torque: shown.torque };
  }

  /// The share of the wrench's force that is shown: it goes to zero where the force is made here.
  #nextRemoteShare(local, now) {
    const passed = Math.max(0, now - this.#sharedAt);
    this.#sharedAt = now;
    this.#remoteShare = local ? Math.max(0, this.#remoteShare - passed / WrenchGovernor.fall)
      : Math.min(1, this.#remoteShare + passed / LocalRenderer.slewTime);
    return this.#remoteShare;
  }

  #modelZeroAt() {
    const { came, measuredAt } = this.#heardModel;
    return Math.min(came + WrenchGovernor.silence, measuredAt + WrenchGovernor.modelAge);
  }

  #isSmall(force) {
    return force <= WrenchGovernor.gate * this.#limits.forceMax;
  }
}

const stampOf = (t) => {
  const nanoseconds = Math.round(1e9 * t);
  return { secs: Math.floor(nanoseconds / 1e9), nsecs: nanoseconds % 1e9 };
};
const vectorOf = (value) => [value?.x, value?.y, value?.z];
/// When the pose was measured that a message answers, in s; NaN for one that does not say.
const timeOf = (message) => {
  const { secs, nsecs } = message?.header?.stamp ?? {};
  return secs + nsecs / 1e9;
};
/// Of a palpate/LocalModel, what isGood() wants.
const modelOf = (message) => ({
  position: vectorOf(message?.position),
  planes: Array.isArray(message?.planes)
    ? message.planes.map((plane) => ({ point: vectorOf(plane?.point), normal: vectorOf(plane?.normal) })) : null,
  stiffness: message?.stiffness,
  damping: message?.damping,
  friction: message?.friction,
  share: message?.share,
});

/// A connection to a running program. Events: 'status' (detail: what the program tells this client, for a person) and
/// 'close'. Where it is lost, nothing but connect() makes another.
export class PalpateClient extends EventTarget {
  #WebSocket;
  #governor;
  #wanted; // topics
  #socket = null;
  #waiting = null; // the newest pose, while what was sent before is still here
  #wrenchCount = 0;

  /// `WebSocket` is a constructor as in browsers; the limits are those of WrenchGovernor.
  constructor({ forceMax, torqueMax = 0, damping = 0, WebSocket = globalThis.WebSocket }) {
    super();
    if (typeof WebSocket !== 'function') throw new TypeError('there is no WebSocket here; give the constructor of ws');
    this.#WebSocket = WebSocket;
    this.#governor = new WrenchGovernor({ forceMax, torqueMax, damping });
    this.#wanted = [topics.wrench, topics.echo, ...(damping > 0 ? [topics.localModel] : [])];
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
    for (const topic of this.#wanted) socket.send(JSON.stringify({ op: 'subscribe', topic }));
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

  /// The same with the handle at `position`, [x, y, z] in m, of the local model where `damping` is known: then 1000 times a
  /// second, and with each position that is sent.
  wrenchAt(position) {
    return this.#governor.showAt(position, PalpateClient.now());
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
    else if (message?.op === 'publish' && message.topic === topics.localModel) this.#takeModel(message.msg, t);
    else this.#governor.fail();
    this.#sendWaiting();
  }

  #answer(seq, t) {
    if (!Number.isSafeInteger(seq) || seq < 0) this.#governor.fail();
    else this.#publish(topics.echoed, { seq, stamp: stampOf(t), frame_id: '' });
  }

  #take(message, t) {
    const wrench = { force: vectorOf(message?.wrench?.force), torque: vectorOf(message?.wrench?.torque) };
    this.#governor.take(wrench, timeOf(message), t);
    this.#wrenchCount += 1;
  }

  #takeModel(message, t) {
    this.#governor.takeModel(modelOf(message), timeOf(message), t);
  }
}
