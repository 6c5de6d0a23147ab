// Panel: recordings, and download of a configuration file with the current settings.

import { byId, element } from '../../shared/dom.js';
import { recordingUrl } from './address.js';
import { button, hint, setPressed } from './fields.js';

const longEnough = 10000; // time for the browser to read an offered file. Unit: [ms].

function download(text, name) {
  const url = URL.createObjectURL(new Blob([text], { type: 'application/toml' }));
  element('a', { attributes: { href: url, download: name } }).click();
  setTimeout(() => URL.revokeObjectURL(url), longEnough);
}

export function createKeepPanel(parameters, actions) {
  const record = button('Record', () => actions.record(!parameters.current.recording), { name: 'record' });
  const report = element('a', { text: 'Last recording', attributes: { href: recordingUrl('recording.html'), target: '_blank', rel: 'noopener' } });
  const raw = element('a', { text: 'as CSV', attributes: { href: recordingUrl('recording'), download: 'recording.csv' } });
  const kept = hint('Kept until the next recording is complete, or the program ends: save it before.');
  const config = button('Save as configuration', async () => {
    const text = await actions.config();
    if (text !== null) download(text, 'palpate.toml');
  }, { name: 'config' });
  const use = hint('To start the next run with these settings: ');
  use.append(element('code', { text: '--config palpate.toml' }), '.');
  byId('keep').append(
    element('div', { className: 'buttons' }, record, report, raw), kept, element('div', { className: 'buttons' }, config),
    use);
  parameters.onChange(({ recording, recorded }) => {
    record.textContent = recording ? 'Stop recording' : 'Record';
    setPressed(record, recording);
    record.classList.toggle('recording', recording);
    report.hidden = raw.hidden = kept.hidden = !recorded;
  });
}
