/** The panel's part for the brush: how large, paint or eraser, and what painted faces mean. */
import { element } from './element.ts';
import { countText, lengthText } from './numbers.ts';
import { countOf } from './painted.ts';
import { choice } from './panel.ts';
import type { Parts } from './parts.ts';
import { differ } from './state.ts';

export function brushPart({ state, results }: Parts): HTMLElement {
  const does = choice(
    'What the brush does',
    [
      { value: 'paint', label: 'Paint' },
      { value: 'erase', label: 'Erase', title: 'Or paint with Shift' },
    ] as const,
    (value) => state.set({ erasing: value === 'erase' }),
  );
  const means = choice(
    'What painted faces mean',
    [
      { value: 'forbid', label: 'Forbidden', title: 'As if they were cut away' },
      { value: 'within', label: 'Only these', title: 'As if all others were cut away' },
    ] as const,
    (as) => state.set({ painted: { ...state.value.painted, as } }),
  );
  // Squared, so that small brushes can be told apart; from a hundredth of the mesh to half of it.
  const size = element('input', { type: 'range', id: 'brush-size', min: '10', max: '70' });
  size.oninput = () => state.set({ brush: (Number(size.value) / 100) ** 2 });
  const radius = element('output', null);
  const said = element('p', { className: 'facts', id: 'painted', role: 'status' });
  const clear = element('button', { type: 'button', className: 'quiet' }, 'Clear the painting');
  clear.onclick = () => state.set({ painted: { ...state.value.painted, faces: [] }, erasing: false });
  const tool = element(
    'div',
    { className: 'stacked' },
    does.root,
    element('div', { className: 'labelled' }, element('label', { htmlFor: 'brush-size' }, 'Radius of the brush'), radius),
    size,
  );
  const root = element(
    'section',
    { className: 'brush-part', hidden: true },
    tool,
    means.root,
    said,
    clear,
  );
  const show = () => {
    const { painted, brush, erasing } = state.value;
    const inHand = state.value.tool === 'brush';
    const { surface } = results.value;
    const count = countOf(painted);
    root.hidden = !inHand && !count;
    tool.hidden = !inHand;
    does.set(erasing ? 'erase' : 'paint');
    does.enable('erase', count > 0);
    means.set(painted.as);
    size.value = `${100 * Math.sqrt(brush)}`;
    radius.textContent = surface ? lengthText(brush * surface.radius) : '';
    const left = painted.as === 'forbid' ? 'forbidden' : 'left';
    said.textContent = count && surface ? `${countText(count)} of ${countText(surface.about.faces)} faces ${left}: every answer is without the hatched ones` : '';
    clear.hidden = !count;
  };
  state.listen((now, before) => {
    // Where no paint is left, there is none to take away.
    if (now.erasing && !now.painted.faces.length) return state.set({ erasing: false });
    if (differ(now, before, 'tool', 'painted', 'brush', 'erasing')) show();
  });
  results.listen((now, before) => now.surface !== before.surface && show());
  show();
  return root;
}
