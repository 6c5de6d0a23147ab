// On a phone the panels are a sheet that comes up from below.

import { byId } from '../../shared/dom.js';

const narrow = matchMedia('(max-width: 720px)');

export function followSheet() {
  const [panels, handle] = [byId('panels'), byId('sheet')];
  const open = (on) => {
    panels.classList.toggle('closed', !on);
    document.body.classList.toggle('panels-open', on); // the view has the rest
    handle.setAttribute('aria-expanded', String(on));
  };
  handle.addEventListener('click', () => open(panels.classList.contains('closed')));
  const fit = () => open(!narrow.matches);
  narrow.addEventListener('change', fit);
  fit();
}
