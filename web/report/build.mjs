// Bundles src/ into one self-contained page: `node build.mjs OUTFILE`.
//
// The page keeps two placeholders, each exactly once, for `palpate report` to fill:
//   <!--PALPATE_TITLE-->     in <title>, replaced by escaped text
//   <!--PALPATE_RUN_JSON-->  in <script type="application/json" id="run">, replaced by JSON in
//                            which every '<' is written \u003c

import { createHash } from 'node:crypto';
import { readFile, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const root = path.dirname(fileURLToPath(import.meta.url));
const placeholders = ['<!--PALPATE_TITLE-->', '<!--PALPATE_RUN_JSON-->'];
const bundledPackages = ['uplot', 'three'];

async function bundle(entry) {
  const result = await build({
    absWorkingDir: root,
    entryPoints: [entry],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: ['es2022'],
    charset: 'utf8',
    legalComments: 'none', // the licences are printed in full in the page's footer
  });
  return result.outputFiles[0].text.trim();
}

async function licenceText(name) {
  const folder = path.join(root, 'node_modules', name);
  const { version } = JSON.parse(await readFile(path.join(folder, 'package.json'), 'utf8'));
  const licence = await readFile(path.join(folder, 'LICENSE'), 'utf8');
  return `${name} ${version}\n\n${licence.trim()}`;
}

const escapeHtml = (text) =>
  text.replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;');

// The page may run its own script and style and load nothing: a browser then refuses whatever a
// run file might smuggle in, besides the escaping.
function contentPolicy(script, style) {
  const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
  return `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}`;
}

// A function as replacement, because `$` has a meaning in replacement strings.
function fill(page, slots) {
  return page.replace(/\{\{(\w+)\}\}/g, (whole, name) => {
    if (!(name in slots)) throw new Error(`template.html: unknown slot ${whole}`);
    return slots[name];
  });
}

function check(page, script, style) {
  for (const token of placeholders) {
    const count = page.split(token).length - 1;
    if (count !== 1) throw new Error(`${token} occurs ${count} times in the page, not once`);
  }
  if (/<\/script|<!--/i.test(script)) throw new Error('the script would end its own element');
  if (/<\/style/i.test(style)) throw new Error('the style sheet would end its own element');
}

async function main(outFile) {
  const script = await bundle('src/main.js');
  const style = await bundle('src/style.css');
  const licences = (await Promise.all(bundledPackages.map(licenceText))).join('\n\n\n');
  const template = await readFile(path.join(root, 'src', 'template.html'), 'utf8');
  const page = fill(template, {
    POLICY: contentPolicy(script, style),
    STYLE: style,
    SCRIPT: script,
    LICENCES: escapeHtml(licences),
  });
  check(page, script, style);
  await writeFile(outFile, page);
}

if (process.argv.length !== 3) {
  console.error('usage: node build.mjs OUTFILE');
  process.exit(2);
}
await main(process.argv[2]);
