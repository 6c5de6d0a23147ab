// Runs with known values for the report page: a tool circles a sphere and touches it now and then.

const sphereRadius = 0.5; // Unit: [m].
const orbitRadius = 0.62; // Unit: [m].
const dip = 0.17; // how far a touch moves the tool towards the sphere. Unit: [m].
const reach = 0.04; // of the tool, its largest semi-axis. Unit: [m].
const stiffness = 60; // Unit: [N/m].

// A small generator with a fixed seed, so that every test sees the same data.
function randomSequence(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

const onSphere = (azimuth, height) => {
  const r = Math.sqrt(1 - height * height);
  return [r * Math.cos(azimuth), r * Math.sin(azimuth), height];
};

export function sphereScene(count) {
  const random = randomSequence(7);
  const points = [];
  const colors = [];
  for (let i = 0; i < count; ++i) {
    const n = onSphere(2 * Math.PI * random(), 2 * random() - 1);
    const r = sphereRadius * (1 + 0.01 * (random() - 0.5));
    points.push(...n.map((v) => r * v));
    const light = 0.55 + 0.45 * (0.5 + 0.5 * n[2]);
    const band = Math.sin(9 * n[2]) > 0 ? [96, 132, 150] : [196, 172, 132];
    colors.push(...band.map((v) => Math.round(light * v)));
  }
  return { points, colors };
}

const columnNames = ['t', 'x', 'y', 'z', 'qw', 'qx', 'qy', 'qz', 'candidates', 'filtered', 'colliding',
  'k_max', 'fx', 'fy', 'fz', 'tx', 'ty', 'tz', 'px', 'py', 'pz', 'compute_us'];
const userForceNames = ['ufx', 'ufy', 'ufz'];

// How deep into a touch a moment is: 0 outside, 1 in its middle.
function touchShape(phase, touches) {
  const inTouch = (phase * touches) % 1;
  const half = 0.17;
  const away = Math.abs(inTouch - 0.5) / half;
  return away < 1 ? 0.5 * (1 + Math.cos(Math.PI * away)) : 0;
}

function poseAt(phase, touches) {
  const azimuth = 2 * Math.PI * 1.6 * phase;
  const normal = onSphere(azimuth, 0.75 * Math.sin(2 * Math.PI * phase + 0.4));
  const distance = orbitRadius + 0.05 * Math.sin(2 * Math.PI * 3.3 * phase) ** 2 - dip * touchShape(phase, touches);
  return { normal, centre: normal.map((v) => distance * v), overlap: sphereRadius + reach - distance };
}

function addRow(columns, contacts, row, t, phase, touches, random, userForce) {
  const { normal, centre, overlap } = poseAt(phase, touches);
  const near = Math.max(0, overlap + 0.09) / 0.09;
  const candidates = Math.round(180 * near ** 1.5 * (0.9 + 0.2 * random()));
  const filtered = Math.round(candidates * Math.min(1, 0.15 + 0.3 * near) * (0.9 + 0.1 * random()));
  const colliding = overlap > 0 ? Math.min(filtered, 1 + Math.round(900 * overlap)) : 0;
  const magnitude = overlap > 0 ? stiffness * overlap : 0;
  const force = normal.map((v) => magnitude * v);
  const contact = normal.map((v) => sphereRadius * v);
  const kMax = overlap > 0 ? Math.min(1, 12 * overlap) : 0;
  const angle = Math.PI * phase;
  const values = {
    t, x: centre[0], y: centre[1], z: centre[2],
    qw: Math.cos(angle), qx: 0, qy: Math.sin(angle), qz: 0,
    candidates, filtered, colliding, k_max: kMax,
    fx: force[0], fy: force[1], fz: force[2], tx: 0, ty: 0, tz: 0,
    px: centre[0], py: centre[1], pz: centre[2],
    compute_us: 2 + 0.4 * candidates + 3 * filtered + 6 * colliding * random(),
    ufx: -force[0] + 0.4 * Math.sin(40 * phase), ufy: -force[1] + 0.3 * Math.cos(31 * phase), ufz: -force[2] - 0.5,
  };
  for (const name of [...columnNames, ...(userForce ? userForceNames : [])]) columns[name].push(values[name]);
  if (overlap > 0 && row % 40 === 0) {
    for (let k = 0; k < 6; ++k) {
      const scatter = contact.map((v) => v + 0.03 * (random() - 0.5));
      ['x', 'y', 'z'].forEach((axis, i) => {
        contacts[axis].push(scatter[i]);
        contacts[`n${axis}`].push(normal[i]);
      });
      contacts.row.push(row);
      contacts.k_min.push(kMax * random());
      contacts.depth.push(overlap);
    }
  }
}

function findEpisodes(columns) {
  const episodes = [];
  const force = (i) => Math.hypot(columns.fx[i], columns.fy[i], columns.fz[i]);
  for (let i = 0; i < columns.t.length; ++i) {
    if (columns.colliding[i] === 0) continue;
    if (i === 0 || columns.colliding[i - 1] === 0) {
      episodes.push({ first: i, last: i, peak: i, onset_t: columns.t[i], position: ['x', 'y', 'z'].map((a) => columns[a][i]), peak_colliding: 0, peak_force: 0 });
    }
    const episode = episodes[episodes.length - 1];
    episode.last = i;
    episode.duration_s = columns.t[i] - episode.onset_t;
    episode.peak_colliding = Math.max(episode.peak_colliding, columns.colliding[i]);
    if (force(i) > episode.peak_force) Object.assign(episode, { peak: i, peak_force: force(i) });
  }
  return episodes;
}

export function sphereRun({ rows = 24000, touches = 7, userForce = true, scenePoints = 40000 } = {}) {
  const random = randomSequence(1);
  const names = [...columnNames, ...(userForce ? userForceNames : [])];
  const columns = Object.fromEntries(names.map((name) => [name, []]));
  const contacts = { row: [], x: [], y: [], z: [], nx: [], ny: [], nz: [], k_min: [], depth: [] };
  for (let row = 0; row < rows; ++row) {
    addRow(columns, contacts, row, row / 1000, row / rows, touches, random, userForce);
  }
  const episodes = findEpisodes(columns);
  const peak = Math.max(0, ...episodes.map((e) => e.peak_force));
  return {
    title: 'sphere.csv',
    generator: 'palpate 0.1.0',
    summary: [
      { label: 'Rows', value: rows.toLocaleString('en-US') },
      { label: 'Duration', value: `${(rows / 1000).toFixed(1)} s` },
      { label: 'Contacts', value: String(episodes.length) },
      { label: 'Peak force', value: `${peak.toFixed(2)} N` },
      { label: 'Computation time, median', value: '38 \u00b5s' },
      { label: '99th percentile', value: '412 \u00b5s' },
    ],
    tool: [{ name: 'tool', semi_axes: [0.02, 0.02, reach], position: [0, 0, 0], orientation: [1, 0, 0, 0] }],
    columns,
    episodes,
    contacts,
    scene: sphereScene(scenePoints),
  };
}

const states = ['waiting', 'rising', 'active', 'falling', 'stopped'];
const faults = ['none', 'bad-pose', 'stale-pose', 'frozen-pose', 'jump', 'over-speed', 'bad-force'];

// Until when, as a share of the run, the governor of a live run is in which state, for which fault.
const governed = [[0.05, 0, 0], [0.1, 1, 0], [0.5, 2, 0], [0.52, 3, 5], [0.6, 4, 5], [0.65, 0, 0], [0.7, 1, 0],
  [0.85, 2, 0], [0.86, 3, 2], [0.87, 4, 2], [0.88, 3, 4], [1, 4, 4]];

/// A live run: sphereRun() with a governor that sees three faults, the last two in one stretch without force.
export function liveRun(options) {
  const run = sphereRun(options);
  const { columns } = run;
  const rows = columns.t.length;
  const governor = { t: [], row: [], state: [], fault: [], states, faults };
  const live = ['vx', 'vy', 'vz', 'sfx', 'sfy', 'sfz', 'state', 'fault', 'energy', 'stored', 'age_us'];
  for (const name of live) columns[name] = [];
  for (let i = 0; i < rows; ++i) {
    const k = governed.findIndex(([until]) => i < until * rows);
    const [, state, fault] = governed[k];
    if (k !== governor.t.length - 1) {
      governor.t.push(columns.t[i]);
      governor.row.push(i);
      governor.state.push(state);
      governor.fault.push(fault);
    }
    columns.state.push(state);
    columns.fault.push(fault);
    for (const axis of ['x', 'y', 'z']) {
      const next = Math.min(i + 1, rows - 1);
      columns[`v${axis}`].push(1000 * (columns[axis][next] - columns[axis][i]));
      columns[`sf${axis}`].push(state === 2 ? columns[`f${axis}`][i] : 0);
    }
    columns.energy.push(0.01 * Math.sin((9 * i) / rows));
    columns.stored.push(0.001 * columns.colliding[i]);
    columns.age_us.push(90 + (i % 7));
  }
  return { ...run, governor };
}

/// The least that a run can be: one row, nothing touched.
export function tinyRun() {
  const columns = Object.fromEntries(columnNames.map((name) => [name, [0]]));
  columns.qw = [1];
  columns.compute_us = [12.5];
  return {
    title: 'tiny.csv', generator: 'palpate 0.1.0', summary: [], tool: null,
    columns, episodes: [], contacts: null, scene: null,
  };
}
