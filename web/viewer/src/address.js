// Addresses of the program that served this page, and the hand that the page is for (?hand=NAME; by default the first).
// A token in the page's address is added to every request.

const asked = new URLSearchParams(location.search);
const token = asked.get('token');
const ofAll = new Set(['messages', 'hands', 'list_scenes', 'open_scene', 'propose_setup']); // shared by all hands

/// Name of the hand that this page is for, which the program may lack; empty: the first.
export const ownHand = asked.get('hand') ?? '';

/// Full name of the topic or service `name` of this page's hand. A name that begins with a slash is full already.
export function rosName(name) {
  if (name.startsWith('/')) return name;
  return ownHand && !ofAll.has(name) ? `/palpate/${ownHand}/${name}` : `/palpate/${name}`;
}

/// URL of a recording of this page's hand.
export const recordingUrl = (file) => httpUrl(ownHand ? `/hands/${ownHand}/${file}` : `/${file}`);

export function httpUrl(path) {
  const url = new URL(path, location.origin);
  if (token) url.searchParams.set('token', token);
  return url.href;
}

export function webSocketUrl() {
  return httpUrl('/').replace(/^http/, 'ws');
}
