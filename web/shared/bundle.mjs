// Functions shared by the build.mjs of the pages.

import { readFile, readdir } from 'node:fs/promises';
import path from 'node:path';
import { build } from 'esbuild';

/// Bundles one script or style sheet of the folder `root`. Returns {text, packages}: `packages` are the folders of the
/// npm packages that it includes.
export async function bundle(root, entry) {
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
    legalComments: 'none', // replaced by the full licences, see licenceTexts()
    logOverride: { 'empty-import-meta': 'silent' }, // Spark uses import.meta only as a module
  });
  const packages = Object.keys(result.metafile.inputs)
    .map((file) => /^.*node_modules\/(?:@[^/]+\/)?[^/]+/.exec(file)?.[0])
    .filter(Boolean)
    .map((folder) => path.join(root, folder));
  return { text: result.outputFiles[0].text.trim(), packages };
}

async function licenceText(folder) {
  const { name, version } = JSON.parse(await readFile(path.join(folder, 'package.json'), 'utf8'));
  const file = (await readdir(folder)).find((f) => /^licen[cs]e/i.test(f));
  if (!file) throw new Error(`${folder}: no licence file`);
  const licence = await readFile(path.join(folder, file), 'utf8');
  return `${name} ${version}\n\n${licence.trim()}`;
}

/// Returns name, version and licence of every package in `bundles`, one text each.
export function licenceTexts(bundles) {
  const folders = new Set(bundles.flatMap(({ packages }) => packages));
  return Promise.all([...folders].sort().map(licenceText));
}

/// Returns the only command-line argument, called `name` in the usage message; exits without one.
export function onlyArgument(name) {
  if (process.argv.length === 3) return process.argv[2];
  console.error(`usage: node build.mjs ${name}`);
  return process.exit(2);
}
