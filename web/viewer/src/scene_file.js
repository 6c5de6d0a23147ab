// A scene file that a person hands over: to the program, which reads it and feels it.

import { httpUrl } from './address.js';

// What other tools write. The program does not read it; its own refusal would come once all of it has been sent.
const foreign = /\.(spz|sog|ksplat|glb|gltf|lcc|usdz|obj)$/i;

/// Why a file of that name is not worth sending, or an empty text.
export function refusalOf(name) {
  if (/\.(ply|splat)$/i.test(name)) return '';
  const kind = foreign.exec(name)?.[0];
  return kind ? `${kind} cannot be read. Convert it first: npx @playcanvas/splat-transform ${name} scene.ply`
    : `${name} is no scene. Give a 3DGS .ply or .splat file.`;
}

/// Promises that the program has all of `file` and opens it; rejected with what it says. `onProgress` gets shares.
export function handOver(file, onProgress, signal) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest(); // fetch() does not say how much has been sent
    request.upload.addEventListener('progress', ({ loaded, total }) => onProgress(total > 0 ? loaded / total : 0));
    request.addEventListener('load', () => (request.status === 200 ? resolve() : reject(new Error(request.responseText.trim() || `status ${request.status}`))));
    request.addEventListener('error', () => reject(new Error(`${file.name} could not be sent.`)));
    request.addEventListener('abort', () => reject(new Error(`${file.name} was not sent.`)));
    signal.addEventListener('abort', () => request.abort());
    request.open('PUT', httpUrl(`/scenes/${encodeURIComponent(file.name)}`));
    request.send(file);
  });
}
