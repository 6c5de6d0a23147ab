// A stand-in for `palpate run` that speaks what docs/gateway.md says, and fails on demand. Its tool is felt as a ball
// and goes where the client's hand is at once.

import { readFile } from 'node:fs/promises';
import http from 'node:http';
import path from 'node:path';
import { WebSocketServer } from 'ws';

import { ballScene, radius } from './mock_scene.mjs';

export const policy = [
  "default-src 'none'", "script-src 'self' 'wasm-unsafe-eval'", "style-src 'self'", "img-src 'self'", "worker-src blob:",
  "connect-src 'self'", "base-uri 'none'", "form-action 'none'", "frame-ancestors 'none'",
].join('; ');
const types = { '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.txt': 'text/plain; charset=utf-8' };
const toolRadius = 0.02; // Unit: [m].
const messagePeriod = 33; // Unit: [ms].
const holdTimeout = 1000; // after the last pose of a client. Unit: [ms].
const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

const xyz = ([x, y, z]) => ({ x, y, z });
const texts = (values) => Object.entries(values).map(([key, value]) => ({ key, value: String(value) }));

function initialParameters(ply) {
  return {
    scene: { name: 'scene.ply', format: 'ply', bytes: ply.length, url: '/scene' },
    registration: { frame: 'as-is', mirrored: false, scale: 1, rotation: [1, 0, 0, 0], translation: [0, 0, 0], matrix: identity, assumed: [] },
    filter: { opacity_min: 0.1, sigma: 1 },
    model: 'proxy', models: ['proxy', 'field', 'density'], frames: ['as-is', 'x-up', 'x-down', 'y-up', 'y-down', 'z-up', 'z-down'],
    stiffness: 500, stiffness_max: 5000, friction: 0, detail: 0,
    tool: [{ name: 'tool', semi_axes: [0.02, 0.02, 0.02], position: [0, 0, 0], orientation: [1, 0, 0, 0] }],
    device: { name: 'omega', kind: 'simulated', force_max: 12, torque_max: 0, workspace: 0.08 },
    room: { scale: 1, rotation: [1, 0, 0, 0], translation: [0, 0, 0] },
    paused: false, recording: false, recorded: false, busy: '', message: '', demo: true,
  };
}

export class MockGateway {
  requests; // of services: {service, args}
  poses; // what clients published
  muted; // says nothing, but keeps the connections
  refusal; // of the next set_parameters
  refusePoses;
  scenesSent; // how often the scene was asked for
  stalls; // half of the way through the scene
  breaksOff = ''; // once this service is asked for
  holdsBack = ''; // the next answer of this service, until the connection breaks off
  fault;
  token; // wanted of every connection, if any
  tool;
  lines; // of the terminal
  velocity; // of the tool. Unit: [m/s].
  margin; // of the stiffness
  setup; // that is proposed
  beforeProposal; // what happens meanwhile
  offered; // scenes: {id, name, bytes, refusal}
  uploaded; // files that were handed over: {name, bytes}
  uploadRefusal; // of the next, if any
  #named = new Map(); // scenes
  #shown = new Set(); // ids of the contacts in the last message
  #heldBack = null; // the answer
  #sockets = new Map(); // socket: Set of topics
  #lastPose;
  #since; // reset(), on the clock of stamps. Unit: [ms].

  constructor(folder, scene = ballScene(600)) {
    this.folder = folder;
    this.reset([0, 0, 0.2], scene);
  }

  /// As it was in the beginning, with the tool at `position`, a scene, and other parameters. Who is connected stays so.
  reset(position, { gaussians, ply }, parameters = {}) {
    Object.assign(this, { gaussians, ply });
    Object.assign(this, {
      requests: [], poses: [], scenesSent: 0, muted: false, refusal: '', stalls: false, uploaded: [], uploadRefusal: '',
      offered: [
        { id: 'built-in', name: 'The built-in still life', bytes: 0, refusal: '' }, { id: '0/cup.ply', name: 'cup.ply', bytes: 5700042, refusal: '' },
        { id: '0/cup.spz', name: 'cup.spz', bytes: 1600000, refusal: '.spz cannot be read; convert it first' },
      ],
      refusePoses: false, token: null, beforeProposal: () => {},
      fault: { level: 0, state: 'active', fault: 'none', advice: '' }, parameters: initialParameters(this.ply),
      tool: { position, orientation: [0, 0, 0, 1] }, lines: ['omega (simulated), tool 20/20/40 mm'], velocity: [0, 0, 0], margin: 3.2,
      setup: {
        frame: { value: 'y-down', reason: 'most of the surface is parallel to it' }, scale: { value: 0.25, reason: 'the median Gaussian is 7 times smaller than the tool' },
        opacity_min: { value: 0.2, reason: 'keeps 96 % of the visible surface' }, max_scale: { value: null, reason: 'none is an outlier' },
        crop_box: { value: [-1, -1, -1, 1, 1, 1], reason: '3 centres are far outside' },
      },
    });
    this.#lastPose = -Infinity;
    this.#since = Date.now();
    this.change({ ...parameters, scene: { ...this.parameters.scene, name: this.#nameOf(ply) } });
  }

  // Another scene, another name: else a page would not load it.
  #nameOf(ply) {
    if (!this.#named.has(ply)) this.#named.set(ply, `scene-${this.#named.size + 1}.ply`);
    return this.#named.get(ply);
  }

  async start(port = 0) {
    this.server = http.createServer((request, response) => this.#respond(request, response));
    const sockets = new WebSocketServer({ server: this.server });
    sockets.on('connection', (socket, request) => this.#connect(socket, request));
    await new Promise((done) => { this.server.listen(port, '127.0.0.1', done); });
    this.port = this.server.address().port;
    this.timer = setInterval(() => this.#tick(), messagePeriod);
    return this;
  }

  async stop() {
    clearInterval(this.timer);
    for (const socket of this.#sockets.keys()) socket.terminate();
    this.#sockets.clear();
    this.server.closeAllConnections();
    await new Promise((done) => { this.server.close(done); });
  }

  get url() {
    return `http://127.0.0.1:${this.port}/`;
  }

  get clients() {
    return this.#sockets.size;
  }

  // The right token, in the address or, after that, in a cookie.
  #isAllowed({ url, headers }) {
    if (!this.token) return true;
    return new URL(url, this.url).searchParams.get('token') === this.token || (headers.cookie ?? '').includes(`token=${this.token}`);
  }

  async #respond(request, response) {
    const { pathname } = new URL(request.url, this.url);
    if (!this.#isAllowed(request)) return response.writeHead(401).end();
    if (request.method === 'PUT') return this.#receiveFile(request, response, decodeURIComponent(pathname));
    if (pathname === '/felt') return response.writeHead(200).end(this.#feltList());
    if (pathname === '/scene') return this.#sendScene(response);
    const name = pathname === '/' ? 'index.html' : path.basename(pathname);
    try {
      const body = await readFile(path.join(this.folder, name));
      const cookie = this.token ? { 'Set-Cookie': `token=${this.token}; HttpOnly; SameSite=Strict` } : {};
      return response.writeHead(200, { 'Content-Type': types[path.extname(name)], 'Content-Security-Policy': policy, ...cookie }).end(body);
    } catch {
      return response.writeHead(404).end();
    }
  }

  async #receiveFile(request, response, pathname) {
    let bytes = 0;
    for await (const chunk of request) bytes += chunk.length;
    if (this.uploadRefusal) return response.writeHead(422).end(this.uploadRefusal);
    this.uploaded.push({ name: pathname.replace('/scenes/', ''), bytes });
    return response.writeHead(200).end('upload complete; opening the scene');
  }

  // All of it, or half of it and the rest once `stalls` is called off.
  #sendScene(response) {
    const { ply } = this;
    this.scenesSent += 1;
    response.writeHead(200, { 'Content-Length': ply.length });
    if (!this.stalls) return response.end(ply);
    response.write(ply.subarray(0, ply.length / 2));
    const goOn = setInterval(() => {
      if (this.stalls && !response.destroyed) return;
      clearInterval(goOn);
      response.end(ply.subarray(ply.length / 2));
    }, messagePeriod);
    return undefined;
  }

  #connect(socket, request) {
    if (!this.#isAllowed(request)) return socket.close();
    this.#sockets.set(socket, new Set());
    this.#shown.clear();
    socket.on('close', () => this.#sockets.delete(socket));
    socket.on('message', (data) => this.#receive(socket, JSON.parse(data)));
    return undefined;
  }

  #receive(socket, message) {
    const send = (answer) => socket.send(JSON.stringify(answer));
    if (message.op === 'subscribe') {
      this.#sockets.get(socket)?.add(message.topic);
      if (message.topic === '/palpate/parameters') send(this.#parametersMessage());
      if (message.topic === '/palpate/messages') send(this.#linesMessage());
    } else if (message.op === 'publish' && message.topic === '/palpate/client/measured_cp') {
      if (this.refusePoses) send({ op: 'status', level: 'error', msg: 'another client holds the tool', id: message.id });
      else this.#pose(message.msg);
    } else if (message.op === 'call_service') {
      this.requests.push({ service: message.service, args: message.args });
      if (message.service === this.breaksOff) {
        this.breaksOff = '';
        this.#heldBack?.();
        this.#heldBack = null;
        socket.close(); // what was sent arrives
        return;
      }
      const values = this.#serve(message.service.replace('/palpate/', ''), message.args);
      const answer = () => send({ op: 'service_response', id: message.id, service: message.service, result: true, values });
      if (message.service === this.holdsBack) {
        this.holdsBack = '';
        this.#heldBack = answer;
      } else answer();
    }
  }

  // What was under way when all began anew belongs to what was before.
  #pose(message) {
    const { secs, nsecs } = message.header.stamp;
    if (1e3 * secs + 1e-6 * nsecs < this.#since) return;
    this.poses.push(message);
    if (this.parameters.demo) this.change({ demo: false });
    const { position: { x, y, z }, orientation: q } = message.pose;
    this.tool = { position: [x, y, z], orientation: [q.x, q.y, q.z, q.w] };
    this.#lastPose = performance.now();
  }

  get isHeld() {
    return performance.now() - this.#lastPose < holdTimeout;
  }

  #serve(name, args) {
    const good = { success: true, message: '' };
    if (name === 'set_parameters') {
      if (this.refusal) return { success: false, message: this.refusal };
      this.change(JSON.parse(args.json));
    } else if (name === 'emergency_stop') {
      this.fault = { level: 2, state: 'stopped', fault: 'emergency-stop', advice: 'resume when it is safe' };
    } else if (name === 'resume') this.fault = { level: 0, state: 'active', fault: 'none', advice: '' };
    else if (name === 'pause') this.change({ paused: args.data });
    else if (name === 'record') this.change({ recording: args.data, recorded: !args.data });
    else if (name === 'demo') this.change({ demo: args.data });
    else if (name === 'propose_setup') {
      this.beforeProposal();
      return { success: true, message: JSON.stringify(this.setup) };
    }
    else if (name === 'list_scenes') return { success: true, message: JSON.stringify(this.offered) };
    else if (name === 'config') return { success: true, message: 'scene = "ball.ply"\n' };
    return good;
  }

  /// Changes parameters and tells everyone.
  change(changes) {
    const { registration, filter, ...rest } = changes;
    Object.assign(this.parameters, rest);
    Object.assign(this.parameters.filter, filter);
    if (registration) {
      const assumed = registration.assumed ?? this.parameters.registration.assumed.filter((name) => !(name in registration));
      Object.assign(this.parameters.registration, registration, { assumed });
      const { scale: s, mirrored, translation: [x, y, z] } = this.parameters.registration;
      this.parameters.registration.matrix = [mirrored ? -s : s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, x, y, z, 1];
    }
    this.#broadcast(this.#parametersMessage());
  }

  get kept() {
    return this.gaussians.filter((g) => g.opacity > this.parameters.filter.opacity_min);
  }

  get #felt() {
    return { url: '/felt', tag: JSON.stringify(this.parameters.filter), count: this.kept.length };
  }

  #feltList() {
    const list = Buffer.alloc(16 * this.kept.length);
    this.kept.forEach(({ row, deviations }, i) => {
      list.writeUInt32LE(row, 16 * i);
      deviations.forEach((d, k) => list.writeFloatLE(d * this.parameters.filter.sigma, 16 * i + 4 * (k + 1)));
    });
    return list;
  }

  #parametersMessage() {
    return { op: 'publish', topic: '/palpate/parameters', msg: { data: JSON.stringify({ ...this.parameters, felt: this.#felt }) } };
  }

  /// Another line of the terminal.
  say(line) {
    this.lines.push(line);
    this.#broadcast(this.#linesMessage());
  }

  #linesMessage() {
    return { op: 'publish', topic: '/palpate/messages', msg: { data: JSON.stringify(this.lines) } };
  }

  #broadcast(message) {
    const text = JSON.stringify(message);
    for (const [socket, topics] of this.#sockets) if (topics.has(message.topic)) socket.send(text);
  }

  /// The force on the tool: away from the ball, proportional to how deep it is.
  get force() {
    const { scale, translation } = this.parameters.registration;
    const from = this.tool.position.map((c, k) => c - translation[k]);
    const distance = Math.hypot(...from);
    const depth = scale * radius + toolRadius - distance;
    const isOn = this.fault.level === 0 && !this.parameters.paused;
    return from.map((c) => (isOn && depth > 0 ? (this.parameters.stiffness * depth * c) / distance : 0));
  }

  /// The Gaussians that the tool touches: {row, center, scale (the diameters), depth}. In the world.
  get contacts() {
    const { scale, translation } = this.parameters.registration;
    return this.kept.map((g) => {
      const center = g.center.map((c, k) => scale * c + translation[k]);
      const depth = toolRadius - Math.hypot(...center.map((c, k) => c - this.tool.position[k]));
      return { ...g, center, scale: g.deviations.map((d) => 2 * scale * d * this.parameters.filter.sigma), depth };
    }).filter((c) => c.depth > 0);
  }

  #tick() {
    if (this.muted) return;
    const now = Date.now();
    const header = { seq: 0, stamp: { secs: Math.floor(now / 1000), nsecs: (now % 1000) * 1e6 }, frame_id: 'world' };
    const say = (topic, msg) => this.#broadcast({ op: 'publish', topic: `/palpate/${topic}`, msg });
    const [x, y, z, w] = this.tool.orientation;
    const pose = { position: xyz(this.tool.position), orientation: { x, y, z, w } };
    const { force } = this;
    const [{ semi_axes: semiAxes }] = this.parameters.tool;
    say('measured_cp', { header, pose });
    say('proxy_cp', { header, pose });
    say('measured_cv', { header, twist: { linear: xyz(this.velocity), angular: xyz([0, 0, 0]) } });
    say('spatial/servo_cf', { header, wrench: { force: xyz(force), torque: xyz([0, 0, 0]) } });
    say('tool', { markers: [{ header, ns: 'tool', id: 0, type: 2, action: 0, pose, scale: xyz(semiAxes.map((a) => 2 * a)), color: { r: 0, g: 0, b: 1, a: 1 } }] });
    say('contacts', { markers: this.#contactMarkers(header) });
    say('diagnostics', { header, status: [{ level: this.fault.level, name: 'palpate: servo', message: '', hardware_id: 'omega', values: texts(this.#diagnostics(force)) }] });
  }

  #diagnostics(force) {
    const { state, fault, advice } = this.parameters.paused
      ? { state: 'stopped', fault: 'paused', advice: 'resume when ready' } : this.fault;
    return {
      state, fault, advice, rate_hz: 1000, tick_us: 21 + 5 * Math.sin(Date.now() / 900), tick_mean_us: 22, tick_p50_us: 20, tick_p99_us: 41, age_us: 12, overruns: 0,
      contacts: this.contacts.length, candidates: 2 * this.contacts.length, k_max: 0.5, force_n: Math.hypot(...force), torque_nm: 0,
      margin: this.margin, energy_mj: 0.1, stored_mj: 0.2, port_energy_mj: 0, damping: 0, clients: this.clients,
    };
  }

  #contactMarkers(header) {
    const { contacts } = this;
    const ids = new Set(contacts.map((c) => c.row));
    const gone = [...this.#shown].filter((id) => !ids.has(id)).flatMap((id) =>
      ['contacts', 'normals'].map((ns) => ({ header, ns, id, action: 2 })));
    this.#shown = ids;
    return [...gone, ...contacts.flatMap((c) => this.#contactPair(header, c))];
  }

  #contactPair(header, { row, n, center, turn: [w, x, y, z], scale, depth }) {
    const tip = center.map((c, k) => c + depth * n[k]);
    const share = Math.min(depth / toolRadius, 1);
    const turn = { x, y, z, w };
    return [
      { header, ns: 'contacts', id: row, type: 2, action: 0, pose: { position: xyz(center), orientation: turn }, scale: xyz(scale), color: { r: 0.4 + 0.55 * share, g: 0.1 + 0.75 * share, b: 0.4, a: 1 } },
      { header, ns: 'normals', id: row, type: 0, action: 0, pose: { position: xyz([0, 0, 0]), orientation: { x: 0, y: 0, z: 0, w: 1 } }, points: [xyz(center), xyz(tip)], scale: xyz([0.001, 0.002, 0]), color: { r: 0, g: 0, b: 0, a: 1 } },
    ];
  }
}
