// Parsing of the run. Missing or invalid parts of the JSON are handled here, so that the charts, the view and the table
// can rely on the result.

import { parseOthers } from './overlay.js';

const forceColumns = ['fx', 'fy', 'fz'];
const torqueColumns = ['tx', 'ty', 'tz'];
const userForceColumns = ['ufx', 'ufy', 'ufz'];
const sentColumns = ['sfx', 'sfy', 'sfz'];
const velocityColumns = ['vx', 'vy', 'vz'];
const liveColumns = [...velocityColumns, ...sentColumns, 'state', 'energy', 'stored', 'age_us'];

const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);
const asList = (value) => (Array.isArray(value) ? value : []);
const numberOrNull = (value) => (isNumber(value) ? value : null);
const textOr = (value, fallback) => (typeof value === 'string' ? value : fallback);

// Column of `length` numbers or nulls. A valid one is not copied: a run may have 300,000 rows.
function cleanColumn(values, length) {
  const list = asList(values);
  const clean = list.length === length && list.every((v) => v === null || isNumber(v));
  return clean ? list : Array.from({ length }, (_, i) => numberOrNull(list[i]));
}

const hasValue = (column) => column.some((v) => v !== null);
const hasNonZero = (column) => column.some((v) => v !== null && v !== 0);

function magnitude(xs, ys, zs) {
  return xs.map((x, i) =>
    x === null || ys[i] === null || zs[i] === null ? null : Math.hypot(x, ys[i], zs[i]));
}

function isTimeAxis(t) {
  return t.every((value, i) => value !== null && (i === 0 || value >= t[i - 1]));
}

/// Onset labels as in the paper's Fig. 5: t_a ... t_z, then t_27, t_28, ...
export function onsetSubscript(index) {
  return index < 26 ? String.fromCharCode(97 + index) : String(index + 1);
}

function vector3(value) {
  const list = asList(value);
  return list.length >= 3 && list.slice(0, 3).every(isNumber) ? list.slice(0, 3) : null;
}

function parseEpisodes(list, rows, timeIsRow, x) {
  const row = (value) => (Number.isInteger(value) && value >= 0 && value < rows ? value : null);
  return asList(list)
    .map((e) => ({ ...e, first: row(e?.first), last: row(e?.last), peak: row(e?.peak) }))
    .filter((e) => e.first !== null && e.last !== null && e.last >= e.first)
    .map((e, index) => ({
      subscript: onsetSubscript(index),
      first: e.first,
      last: e.last,
      peak: e.peak ?? e.first,
      onset: timeIsRow || !isNumber(e.onset_t) ? x[e.first] : e.onset_t,
      duration: numberOrNull(e.duration_s),
      position: vector3(e.position),
      peakColliding: numberOrNull(e.peak_colliding),
      peakForce: numberOrNull(e.peak_force),
      maxDepth: null,
    }));
}

// Contacts without a position are dropped; the view handles a missing normal or K_min.
function parseContacts(contacts) {
  const length = asList(contacts?.x).length;
  if (length === 0) return null;
  const column = (name) => cleanColumn(contacts[name], length);
  const [row, x, y, z] = ['row', 'x', 'y', 'z'].map(column);
  const [nx, ny, nz, kMin, depth] = ['nx', 'ny', 'nz', 'k_min', 'depth'].map(column);
  const kept = [...x.keys()].filter((i) => x[i] !== null && y[i] !== null && z[i] !== null);
  return kept.map((i) => ({
    row: row[i],
    position: [x[i], y[i], z[i]],
    normal: vector3([nx[i], ny[i], nz[i]]),
    kMin: kMin[i],
    depth: depth[i],
  }));
}

// Substitute for recorded contact points: the tool centres of the rows in contact.
function toolCentresInContact(col, rows) {
  const points = [];
  for (let i = 0; i < rows; ++i) {
    const position = vector3([col.x[i], col.y[i], col.z[i]]);
    if (col.colliding[i] > 0 && position) {
      points.push({ row: i, position, normal: null, kMin: col.k_max[i], depth: null });
    }
  }
  return points;
}

// Sets the largest depth of each episode. Contacts are in any order and are assigned by row.
function addMaxDepths(episodes, contacts) {
  const byRow = contacts
    .filter((c) => c.row !== null && c.depth !== null)
    .sort((a, b) => a.row - b.row);
  let next = 0;
  for (const episode of episodes) {
    while (next < byRow.length && byRow[next].row < episode.first) ++next;
    for (; next < byRow.length && byRow[next].row <= episode.last; ++next) {
      episode.maxDepth = Math.max(episode.maxDepth ?? -Infinity, byRow[next].depth);
    }
  }
}

function parseScene(scene) {
  const points = asList(scene?.points);
  const count = Math.floor(points.length / 3);
  if (count === 0) return null;
  const colors = asList(scene.colors);
  return {
    positions: Float32Array.from(points.slice(0, 3 * count), (v) => (isNumber(v) ? v : NaN)),
    colors: colors.length >= 3 * count ? Uint8Array.from(colors.slice(0, 3 * count)) : null,
  };
}

function parseSummary(list) {
  return asList(list).map((item) => ({
    label: String(item?.label ?? ''),
    value: String(item?.value ?? ''),
  }));
}

const listOfTexts = (list) => asList(list).map((item) => String(item));

// States of the safety governor as intervals, and its faults; null if there are none.
function parseGovernor(json, rows, timeIsRow, x) {
  const [states, faults] = [listOfTexts(json?.states), listOfTexts(json?.faults)];
  const starts = asList(json?.t)
    .map((t, i) => ({ t, row: asList(json.row)[i], state: states[asList(json.state)[i]], fault: asList(json.fault)[i] }))
    .filter((s) => s.state !== undefined && Number.isInteger(s.row) && s.row >= 0 && s.row < rows)
    .map((s) => ({ ...s, from: timeIsRow || !isNumber(s.t) ? x[s.row] : s.t }));
  if (starts.length === 0) return null;
  const stretches = starts.map((s, i) => ({ from: s.from, to: starts[i + 1]?.from ?? x[rows - 1], state: s.state }));
  const begins = (s, i) => s.fault > 0 && faults[s.fault] !== undefined && s.fault !== starts[i - 1]?.fault;
  return { states, stretches, faults: starts.filter(begins).map((s) => ({ at: s.from, row: s.row, name: faults[s.fault] })) };
}

function parseColumns(columns) {
  const source = columns && typeof columns === 'object' ? columns : {};
  const rows = Math.max(0, ...Object.values(source).map((c) => asList(c).length));
  const names = ['t', 'x', 'y', 'z', 'qw', 'qx', 'qy', 'qz', 'candidates', 'filtered', 'colliding',
    'k_max', ...forceColumns, ...torqueColumns, ...userForceColumns, 'compute_us'];
  const hasLive = liveColumns.every((name) => Array.isArray(source[name]));
  if (hasLive) names.push(...liveColumns);
  const col = Object.fromEntries(names.map((name) => [name, cleanColumn(source[name], rows)]));
  const magnitudeOf = (vector) => magnitude(...vector.map((name) => cleanColumn(source[name], rows)));
  col.force = magnitudeOf(forceColumns);
  if (sentColumns.every((name) => Array.isArray(source[name]))) col.sent = magnitudeOf(sentColumns);
  if (hasLive) col.speed = magnitudeOf(velocityColumns);
  return { rows, col, hasLive };
}

/// \throws SyntaxError if `text` is not JSON.
export function parseRun(text) {
  const json = JSON.parse(text);
  const { rows, col, hasLive } = parseColumns(json?.columns);
  const timeIsRow = !isTimeAxis(col.t);
  const x = timeIsRow ? col.t.map((_, i) => i) : col.t;
  const episodes = parseEpisodes(json?.episodes, rows, timeIsRow, x);
  const recorded = parseContacts(json?.contacts);
  if (recorded) addMaxDepths(episodes, recorded);
  return {
    title: textOr(json?.title, 'Run'),
    generator: textOr(json?.generator, ''),
    made: textOr(json?.made, ''),
    summary: parseSummary(json?.summary),
    tool: toolParts(json?.tool),
    rows,
    col,
    x,
    timeIsRow,
    episodes,
    contacts: recorded ?? toolCentresInContact(col, rows),
    contactsRecorded: recorded !== null,
    scene: parseScene(json?.scene),
    others: parseOthers(json?.others, x, parseColumns),
    governor: hasLive ? parseGovernor(json?.governor, rows, timeIsRow, x) : null,
    hasLive,
    hasUserForce: userForceColumns.some((name) => hasValue(col[name])),
    hasTorque: torqueColumns.some((name) => hasNonZero(col[name])),
  };
}

/// Ellipsoids of the tool in its own frame: semi-axes, position, and orientation as x, y, z, w. Null if the tool is
/// unknown.
function toolParts(json) {
  if (!Array.isArray(json)) return null;
  const parts = json.map((part) => {
    const [w, ...xyz] = part?.orientation ?? [];
    const orientation = [...xyz, w].every(isNumber) && xyz.length === 3 ? [...xyz, w] : null;
    return { semiAxes: vector3(part?.semi_axes), position: vector3(part?.position), orientation };
  });
  return parts.every((p) => p.semiAxes && p.position && p.orientation) && parts.length > 0 ? parts : null;
}

/// Tool centre [x, y, z] in a row, or null.
export function toolPosition(run, row) {
  return vector3([run.col.x[row], run.col.y[row], run.col.z[row]]);
}

/// Orientation [x, y, z, w] of the tool in a row; identity if it is missing.
export function toolOrientation(run, row) {
  const q = ['qx', 'qy', 'qz', 'qw'].map((name) => run.col[name][row]);
  return q.every(isNumber) && Math.hypot(...q) > 0 ? q : [0, 0, 0, 1];
}
