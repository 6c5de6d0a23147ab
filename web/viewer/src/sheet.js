// On a phone, the panels are a sheet: at the bottom in portrait, at the side in landscape orientation.

import { byId } from '../../shared/dom.js';

const small = matchMedia('(max-width: 720px), (max-height: 480px)');

export function followSheet() {
  const [panels, handle] = [byId('panels'), byId('sheet')];
  const open = (on) => {
    panels.classList.toggle('closed', !on);
    document.body.classList.toggle('panels-open', on); // leaves the rest to the view
    handle.setAttribute('aria-expanded', String(on));
  };
  handle.addEventListener('click', () => open(panels.classList.contains('closed')));
  const fit = () => open(!small.matches);
  small.addEventListener('change', fit);
  fit();
}
