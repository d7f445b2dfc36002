/** The panel's part for the disc round the sources: how far it reaches, how large it is and how long its outline. */
import { element } from './element.ts';
import { lengthText } from './numbers.ts';
import type { Parts } from './parts.ts';
import { byCost, differ } from './state.ts';
import { unitOf } from './units.ts';

/** Of the greatest distance, when the disc is switched on. */
const AT_FIRST = 0.3;

export function discPart({ state, results }: Parts): HTMLElement {
  const on = element('input', { type: 'checkbox', id: 'disc' });
  const slider = element('input', { type: 'range', id: 'disc-radius', min: '1', max: '1000', aria: { label: 'Radius of the disc' } });
  const radius = element('output', null);
  const said = element('p', { className: 'facts', id: 'disc-said', role: 'status' });
  const root = element('section', { className: 'disc-part', hidden: true },
    element('div', { className: 'labelled' }, element('label', { className: 'check', htmlFor: 'disc' }, on, 'Area within a radius'), radius), slider, said);
  const most = () => results.value.field?.max ?? 0;
  const rounded = (length: number) => Number(length.toPrecision(3));
  on.onchange = () => state.set({ disc: on.checked && most() > 0 ? rounded(AT_FIRST * most()) : null });
  slider.oninput = () => state.set({ disc: rounded((Number(slider.value) / 1000) * most()) });
  const show = () => {
    const { sources, curves, disc } = state.value;
    const { surface, field, disc: answered } = results.value;
    root.hidden = byCost(state.value) || (!sources.length && !curves.length);
    on.checked = disc !== null;
    on.disabled = disc === null && !(most() > 0);
    slider.hidden = said.hidden = disc === null;
    if (disc === null) return void (radius.textContent = '');
    if (field && field.max > 0) slider.value = `${(1000 * disc) / field.max}`;
    radius.textContent = lengthText(disc);
    const unit = surface ? unitOf(surface.about) : '';
    root.classList.toggle('stale', answered?.radius !== disc);
    said.textContent = answered ? `${lengthText(answered.area)}${unit && ` ${unit}²`} · outline ${lengthText(answered.outline)}${unit && ` ${unit}`}` : '…';
  };
  state.listen((now, before) => differ(now, before, 'disc', 'walking', 'painted', 'sources', 'curves') && show());
  results.listen((now, before) => differ(now, before, 'disc', 'field', 'surface') && show());
  show();
  return root;
}
