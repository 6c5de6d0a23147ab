// Where the program that served this page is. A token in the page's own address goes along with every request.

const token = new URLSearchParams(location.search).get('token');

export function httpUrl(path) {
  const url = new URL(path, location.origin);
  if (token) url.searchParams.set('token', token);
  return url.href;
}

export function webSocketUrl() {
  return httpUrl('/').replace(/^http/, 'ws');
}
