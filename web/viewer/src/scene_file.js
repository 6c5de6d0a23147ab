// Upload of a scene file to the program, which opens it.

import { httpUrl } from './address.js';

// File types of other tools, rejected here: the program would reject them only after the upload.
const foreign = /\.(spz|sog|ksplat|glb|gltf|lcc|usdz|obj)$/i;

/// Reason to reject a file of that name; empty if there is none.
export function refusalOf(name) {
  if (/\.(ply|splat)$/i.test(name)) return '';
  const kind = foreign.exec(name)?.[0];
  return kind ? `${kind} cannot be read. Convert it first: npx @playcanvas/splat-transform ${name} scene.ply`
    : `${name} is not a scene file. Use a 3DGS .ply or .splat file.`;
}

/// Uploads `file`. Resolves once the program has received it and opens it; rejects with its message. `onProgress`
/// receives fractions.
export function handOver(file, onProgress, signal) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest(); // fetch() does not report upload progress
    request.upload.addEventListener('progress', ({ loaded, total }) => onProgress(total > 0 ? loaded / total : 0));
    request.addEventListener('load', () => (request.status === 200 ? resolve() : reject(new Error(request.responseText.trim() || `status ${request.status}`))));
    request.addEventListener('error', () => reject(new Error(`The upload of ${file.name} failed.`)));
    request.addEventListener('abort', () => reject(new Error(`The upload of ${file.name} was cancelled.`)));
    signal.addEventListener('abort', () => request.abort());
    request.open('PUT', httpUrl(`/scenes/${encodeURIComponent(file.name)}`));
    request.send(file);
  });
}
