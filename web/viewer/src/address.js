// Where the program that served this page is, and which of its hands this page is for (?hand=NAME; else the first). A token in the
// page's own address goes along with every request.

const asked = new URLSearchParams(location.search);
const token = asked.get('token');
const ofAll = new Set(['messages', 'hands', 'list_scenes', 'open_scene', 'propose_setup']); // what only the first has, for all

/// The name of the hand that this page is for; empty: the first.
export const ownHand = /^[a-z][a-z0-9_]*$/.test(asked.get('hand') ?? '') ? asked.get('hand') : '';

/// The topic or service of this page's hand that is called `name` below /palpate/.
export const rosName = (name) => (ownHand && !ofAll.has(name) ? `/palpate/${ownHand}/${name}` : `/palpate/${name}`);

/// Where a recording of this page's hand is.
export const recordingUrl = (file) => httpUrl(ownHand ? `/hands/${ownHand}/${file}` : `/${file}`);

export function httpUrl(path) {
  const url = new URL(path, location.origin);
  if (token) url.searchParams.set('token', token);
  return url.href;
}

export function webSocketUrl() {
  return httpUrl('/').replace(/^http/, 'ws');
}
