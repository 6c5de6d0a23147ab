// On a phone the panels are a sheet: from below where it is held upright, at the side where it lies.

import { byId } from '../../shared/dom.js';

const small = matchMedia('(max-width: 720px), (max-height: 480px)');

export function followSheet() {
  const [panels, handle] = [byId('panels'), byId('sheet')];
  const open = (on) => {
    panels.classList.toggle('closed', !on);
    document.body.classList.toggle('panels-open', on); // the view has the rest
    handle.setAttribute('aria-expanded', String(on));
  };
  handle.addEventListener('click', () => open(panels.classList.contains('closed')));
  const fit = () => open(!small.matches);
  small.addEventListener('change', fit);
  fit();
}
