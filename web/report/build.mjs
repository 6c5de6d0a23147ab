// Bundles src/ into one self-contained page: `node build.mjs OUTFILE`.
//
// The page contains two placeholders, each exactly once, which `palpate report` fills:
//   <!--PALPATE_TITLE-->     in <title>, replaced by escaped text
//   <!--PALPATE_RUN_JSON-->  in <script type="application/json" id="run">, replaced by JSON in
//                            which every '<' is written \u003c

import { createHash } from 'node:crypto';
import { readFile, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { bundle, licenceTexts, onlyArgument } from '../shared/bundle.mjs';

const root = path.dirname(fileURLToPath(import.meta.url));
const placeholders = ['<!--PALPATE_TITLE-->', '<!--PALPATE_RUN_JSON-->'];

const escapeHtml = (text) =>
  text.replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;');

// The page may run its own script and style and load nothing: a second protection, besides the escaping, against
// content injected by a run file.
function contentPolicy(script, style) {
  const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
  return `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}`;
}

// The replacement is a function, because `$` is special in replacement strings.
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
  const bundles = [await bundle(root, 'src/main.js'), await bundle(root, 'src/style.css')];
  const [script, style] = bundles.map(({ text }) => text);
  const licences = (await licenceTexts(bundles)).join('\n\n\n');
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

await main(onlyArgument('OUTFILE'));
