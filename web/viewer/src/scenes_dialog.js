// Opening of another scene: from the program's list, or a dropped or chosen file. No restart is needed.

import { byId, element } from '../../shared/dom.js';
import { cancelledByEscape } from './escape.js';
import { formatBytes } from './format.js';
import { notify } from './notices.js';
import { handOver, refusalOf } from './scene_file.js';

/// `list` resolves to the scenes as JSON, or null; `open` opens one by its id. Returns a function that shows it.
export function createScenesDialog({ list, open, parameters }) {
  const dialog = byId('scenes');
  let forget = () => {};
  const close = () => {
    forget(); // not only on the close event: the next Escape must stop the force
    dialog.close();
  };
  const show = async () => {
    if (dialog.open) return;
    dialog.showModal();
    forget = cancelledByEscape(() => dialog.close());
    byId('scene-list').replaceChildren(element('li', { className: 'hint', text: 'Searching for scenes…' }));
    const text = await list();
    const entries = text === null ? [] : JSON.parse(text);
    byId('scene-list').replaceChildren(...entries.map((entry) => row(entry, parameters.current?.scene.name, () => {
      close();
      open(entry.id);
    })));
  };
  const send = createSender();
  const file = byId('scene-file');
  file.addEventListener('change', () => {
    const [chosen] = file.files;
    close();
    if (chosen) send(chosen);
    file.value = '';
  });
  dialog.addEventListener('close', () => forget());
  byId('open').addEventListener('click', show);
  byId('scenes-close').addEventListener('click', close);
  byId('choose-file').addEventListener('click', () => file.click());
  followDrops((dropped) => {
    if (dialog.open) close();
    send(dropped);
  });
  return show;
}

function row({ name, bytes, refusal }, current, pick) {
  const size = bytes > 0 ? formatBytes(bytes) : '';
  const node = element('button', { attributes: { type: 'button', 'data-scene': name } },
    element('span', { text: name }), element('span', { className: 'muted', text: size }));
  node.disabled = refusal !== '';
  if (name === current) node.setAttribute('aria-current', 'true');
  node.addEventListener('click', pick);
  return element('li', {}, node, ...(refusal ? [element('p', { className: 'hint', text: refusal })] : []));
}

// Uploads files to the program, one at a time, with a progress bar.
function createSender() {
  const [box, bar, text, cancel] = ['sending', 'sending-bar', 'sending-text', 'sending-cancel'].map(byId);
  let sending = null;
  cancel.addEventListener('click', () => sending?.abort());
  return async (file) => {
    const refusal = sending ? 'Another upload is in progress.' : refusalOf(file.name);
    if (refusal) {
      notify(refusal);
      return;
    }
    sending = new AbortController();
    box.hidden = false;
    bar.value = 0;
    text.textContent = `Uploading ${file.name}, ${formatBytes(file.size)}`;
    try {
      await handOver(file, (share) => { bar.value = share; }, sending.signal);
    } catch (error) {
      notify(error.message);
    }
    sending = null;
    box.hidden = true;
  };
}

// Accepts files dropped anywhere on the page.
function followDrops(take) {
  const hasFile = (event) => [...(event.dataTransfer?.types ?? [])].includes('Files');
  const mark = (on) => document.body.classList.toggle('dropping', on);
  window.addEventListener('dragover', (event) => {
    if (!hasFile(event)) return;
    event.preventDefault();
    mark(true);
  });
  window.addEventListener('dragleave', (event) => { if (event.relatedTarget === null) mark(false); });
  window.addEventListener('drop', (event) => {
    if (!hasFile(event)) return;
    event.preventDefault();
    mark(false);
    const [file] = event.dataTransfer.files;
    if (file) take(file);
  });
}
