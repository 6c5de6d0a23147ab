// Bundles src/ into the files of the viewer page: `node build.mjs FOLDER`.
//
// FOLDER receives index.html, viewer.js, viewer.css, icon.svg and licences.txt. The page loads nothing that the gateway
// does not serve, so that it works without a network and under a strict Content-Security-Policy.

import { copyFile, mkdir, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { bundle, licenceTexts, onlyArgument } from '../shared/bundle.mjs';

const root = path.dirname(fileURLToPath(import.meta.url));

async function main(outFolder) {
  const [script, style] = [await bundle(root, 'src/main.js'), await bundle(root, 'src/style.css')];
  const licences = await licenceTexts([script, style]);
  await mkdir(outFolder, { recursive: true });
  await writeFile(path.join(outFolder, 'viewer.js'), script.text);
  await writeFile(path.join(outFolder, 'viewer.css'), style.text);
  await writeFile(path.join(outFolder, 'licences.txt'), `${licences.join(`\n\n\n${'-'.repeat(80)}\n\n\n`)}\n`);
  for (const file of ['index.html', 'icon.svg']) {
    await copyFile(path.join(root, 'src', file), path.join(outFolder, file));
  }
}

await main(onlyArgument('FOLDER'));
