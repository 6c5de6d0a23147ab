// Bundles src/ into the files of the viewer page: `node build.mjs FOLDER`.
//
// FOLDER gets exactly index.html, viewer.js, viewer.css, icon.svg and licences.txt. The page loads nothing else
// but what the gateway serves, so that it works without a network and under a strict Content-Security-Policy.

import { copyFile, mkdir, readFile, readdir, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const root = path.dirname(fileURLToPath(import.meta.url));

async function bundle(entry) {
  const result = await build({
    absWorkingDir: root,
    entryPoints: [entry],
    bundle: true,
    minify: true,
    write: false,
    metafile: true,
    format: 'iife',
    target: ['es2022'],
    charset: 'utf8',
    legalComments: 'none', // the licences are in licences.txt, in full
    logOverride: { 'empty-import-meta': 'silent' }, // Spark asks where it is only if it is a module
  });
  return { text: result.outputFiles[0].text, inputs: Object.keys(result.metafile.inputs) };
}

// The folders of the packages that have a part in the bundle.
function packageFolders(inputs) {
  const folders = inputs.map((file) => /^.*node_modules\/(?:@[^/]+\/)?[^/]+/.exec(file)?.[0]);
  return [...new Set(folders.filter(Boolean))].sort();
}

async function licenceText(folder) {
  const { name, version } = JSON.parse(await readFile(path.join(root, folder, 'package.json'), 'utf8'));
  const file = (await readdir(path.join(root, folder))).find((f) => /^licen[cs]e/i.test(f));
  if (!file) throw new Error(`${folder}: no licence file`);
  const licence = await readFile(path.join(root, folder, file), 'utf8');
  return `${name} ${version}\n\n${licence.trim()}`;
}

async function main(outFolder) {
  const script = await bundle('src/main.js');
  const style = await bundle('src/style.css');
  const folders = packageFolders([...script.inputs, ...style.inputs]);
  const licences = await Promise.all(folders.map(licenceText));
  await mkdir(outFolder, { recursive: true });
  await writeFile(path.join(outFolder, 'viewer.js'), script.text);
  await writeFile(path.join(outFolder, 'viewer.css'), style.text);
  await writeFile(path.join(outFolder, 'licences.txt'), `${licences.join(`\n\n\n${'-'.repeat(80)}\n\n\n`)}\n`);
  for (const file of ['index.html', 'icon.svg']) {
    await copyFile(path.join(root, 'src', file), path.join(outFolder, file));
  }
}

if (process.argv.length !== 3) {
  console.error('usage: node build.mjs FOLDER');
  process.exit(2);
}
await main(process.argv[2]);
