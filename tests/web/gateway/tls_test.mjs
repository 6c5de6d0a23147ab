// HTTPS and WSS, with certificates that openssl makes here.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import https from 'node:https';
import http from 'node:http';
import { readFileSync, writeFileSync } from 'node:fs';
import net from 'node:net';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import tls from 'node:tls';
import WebSocket from 'ws';
import { makeFolder, start } from './palpate.mjs';

const patience = 60_000; // ms

/// As docs/gateway.md says it: NAME-cert.pem and NAME-key.pem in a folder.
function makeCertificate(folder, name, kind = ['rsa:2048']) {
  execFileSync('openssl', ['req', '-x509', '-newkey', ...kind, '-nodes', '-days', '365', '-subj', '/CN=palpate',
    '-addext', 'subjectAltName=DNS:localhost,IP:127.0.0.1', '-keyout', `${name}-key.pem`, '-out', `${name}-cert.pem`],
  { cwd: folder, stdio: 'ignore' });
}

let scene;
before(() => {
  scene = makeFolder();
  makeCertificate(scene.folder, 'own');
  makeCertificate(scene.folder, 'other');
  makeCertificate(scene.folder, 'curve', ['ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1']);
});
after(() => scene.remove());

const certificate = (name = 'own') => readFileSync(path.join(scene.folder, `${name}-cert.pem`));
const options = (name = 'own') => ['--tls-cert', `${name}-cert.pem`, '--tls-key', `${name}-key.pem`];

/// Status, headers and body of an answer.
const ask = (url, more = {}) => new Promise((done, failed) => {
  const request = https.get(url, { ca: certificate(), ...more }, (answer) => {
    const pieces = [];
    answer.on('data', (piece) => pieces.push(piece));
    answer.on('end', () => done({ status: answer.statusCode, headers: answer.headers, body: Buffer.concat(pieces) }));
  });
  request.on('error', failed);
});

/// A client of rosbridge, once it is connected.
const dial = (url, more = {}) => new Promise((done, failed) => {
  const socket = new WebSocket(url.replace('https', 'wss'), { ca: certificate(), ...more });
  socket.on('open', () => done(socket));
  socket.on('error', failed);
});

const nextMessage = (socket, fits) => new Promise((found, failed) => {
  const timer = setTimeout(() => failed(new Error('nothing that fits came')), patience);
  socket.on('message', function look(bytes) {
    const message = JSON.parse(bytes);
    if (!fits(message)) return;
    clearTimeout(timer);
    socket.off('message', look);
    found(message);
  });
});

describe('a gateway with TLS', () => {
  let palpate;
  before(async () => { palpate = await start(scene.folder, ...options()); });
  after(async () => { assert.ok((await palpate.stop()).ticks > 0); });

  test('says where it is, and serves pages and files there', async () => {
    assert.match(palpate.url, /^https:/);
    const page = await ask(palpate.url);
    assert.equal(page.status, 200);
    assert.match(String(page.body), /<script/);
    const file = await ask(`${palpate.url}scene`);
    assert.deepEqual(file.body, readFileSync(path.join(scene.folder, 'sphere.ply')));
    assert.equal((await ask(`${palpate.url}scene`, { headers: { range: 'bytes=10-19' } })).body.length, 10);
  });

  test('speaks rosbridge over WSS', async () => {
    const socket = await dial(palpate.url);
    socket.send(JSON.stringify({ op: 'subscribe', topic: '/palpate/measured_cp', type: 'geometry_msgs/PoseStamped' }));
    const { msg } = await nextMessage(socket, ({ topic }) => topic === '/palpate/measured_cp');
    assert.ok(Number.isFinite(msg.pose.position.x));
    socket.send(JSON.stringify({ op: 'call_service', id: 'p', service: '/palpate/get_parameters' }));
    const answer = await nextMessage(socket, ({ id }) => id === 'p');
    assert.equal(JSON.parse(answer.values.message).scene.name, 'sphere.ply');
    socket.close();
  });

  test('takes a client that holds the tool', async () => {
    const socket = await dial(palpate.url);
    socket.send(JSON.stringify({ op: 'advertise', topic: '/palpate/client/measured_cp', type: 'geometry_msgs/PoseStamped' }));
    socket.send(JSON.stringify({ op: 'subscribe', topic: '/palpate/spatial/servo_cf', type: 'geometry_msgs/WrenchStamped' }));
    const pose = { position: { x: 0, y: 0, z: 0.3 }, orientation: { x: 0, y: 0, z: 0, w: 1 } };
    const send = () => socket.send(JSON.stringify({ op: 'publish', topic: '/palpate/client/measured_cp',
      msg: { header: { frame_id: 'world' }, pose } }));
    const beat = setInterval(send, 10);
    for (let k = 0; k < 20; ++k) await nextMessage(socket, ({ topic }) => topic === '/palpate/spatial/servo_cf');
    clearInterval(beat);
    socket.close();
  });

  test('goes on while a peer says nothing, nonsense, or goes away', async () => {
    const { hostname, port } = new URL(palpate.url);
    const silent = Array.from({ length: 40 }, () => net.connect(Number(port), hostname));
    silent.forEach((socket) => socket.on('error', () => {}));
    const rude = net.connect(Number(port), hostname);
    rude.on('error', () => {});
    rude.write('GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n');
    const gone = tls.connect({ port: Number(port), host: hostname, ca: certificate() });
    gone.on('error', () => {});
    await new Promise((done) => { gone.on('secureConnect', done); });
    gone.destroy();
    assert.equal((await ask(`${palpate.url}healthz`)).status, 200);
    silent.forEach((socket) => socket.destroy());
    rude.destroy();
  });

  test('does not answer without TLS, nor with an old one', async () => {
    const plain = new Promise((done) => {
      http.get(palpate.url.replace('https', 'http'), () => done('answered')).on('error', () => done('refused'));
    });
    assert.equal(await plain, 'refused');
    await assert.rejects(ask(palpate.url, { maxVersion: 'TLSv1.1', minVersion: 'TLSv1', ciphers: 'DEFAULT@SECLEVEL=0' }));
  });

  test('is not trusted under another certificate', async () => {
    await assert.rejects(ask(palpate.url, { ca: certificate('other') }), /self-signed|certificate/);
  });
});

test('with a token the cookie is for TLS alone, and the token is asked for', async () => {
  const token = '0123456789abcdef0123';
  const palpate = await start(scene.folder, ...options('curve'), '--token', token);
  const ca = certificate('curve');
  assert.equal((await ask(palpate.url, { ca })).status, 401);
  const first = await ask(`${palpate.url}?token=${token}`, { ca });
  assert.match(first.headers['set-cookie'][0], /HttpOnly.*Secure/);
  const cookie = first.headers['set-cookie'][0].split(';')[0];
  assert.equal((await ask(palpate.url, { ca, headers: { cookie } })).status, 200);
  await assert.rejects(dial(palpate.url, { ca }), /401/);
  (await dial(`${palpate.url}?token=${token}`, { ca })).close();
  await palpate.stop();
});

test('files that are wrong are refused with one line', () => {
  writeFileSync(path.join(scene.folder, 'text.pem'), 'no certificate\n');
  execFileSync('openssl', ['rsa', '-in', 'own-key.pem', '-aes128', '-passout', 'pass:secret', '-out', 'locked.pem'],
    { cwd: scene.folder, stdio: 'ignore' });
  const cases = [
    [['--tls-cert', 'own-cert.pem'], /--tls-cert and --tls-key/],
    [['--tls-key', 'own-key.pem'], /--tls-cert and --tls-key/],
    [['--tls-cert', 'no.pem', '--tls-key', 'own-key.pem'], /no\.pem.*No such file/],
    [['--tls-cert', 'own-cert.pem', '--tls-key', '.'], /folder/],
    [['--tls-cert', 'text.pem', '--tls-key', 'own-key.pem'], /text\.pem.*--tls-cert/],
    [['--tls-cert', 'own-cert.pem', '--tls-key', 'text.pem'], /text\.pem.*--tls-key/],
    [['--tls-cert', 'own-cert.pem', '--tls-key', 'locked.pem'], /locked\.pem.*password/],
    [['--tls-cert', 'own-cert.pem', '--tls-key', 'other-key.pem'], /other-key\.pem.*not match the certificate own-cert\.pem/],
    [['--tls-cert', 'own-cert.pem', '--tls-key', 'curve-key.pem'], /curve-key\.pem.*not match the certificate own-cert\.pem/],
  ];
  for (const [args, words] of cases) {
    const result = spawnSync(process.env.PALPATE, ['run', 'sphere.ply', '--port', '0', '-q', '--seconds', '1', ...args],
      { cwd: scene.folder, encoding: 'utf8', input: '' });
    assert.equal(result.status, 1, `${args}: ${result.stderr}`);
    assert.match(result.stderr, words);
    assert.equal(result.stderr.trim().split('\n').length, 1, result.stderr);
  }
});
