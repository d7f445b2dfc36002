/** The panel's part for the brush: how large, paint or eraser, and what painted faces mean. */
import { element } from './element.ts';
import { countText, lengthText } from './numbers.ts';
import { countOf, LEAST_WEIGHT, MOST_WEIGHT } from './painted.ts';
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
      { value: 'weights', label: 'Weighted', title: 'A path over them costs a multiple of what it does elsewhere, or a part of it. The method is Steiner then' },
    ] as const,
    (as) => state.set({ painted: { ...state.value.painted, as } }),
  );
  // Squared, so that small brushes can be told apart; from a hundredth of the mesh to half of it.
  const size = element('input', { type: 'range', id: 'brush-size', min: '10', max: '70' });
  size.oninput = () => state.set({ brush: (Number(size.value) / 100) ** 2 });
  const radius = element('output', null);
  const times = element('output', null);
  // By powers: 1 is in the middle.
  const weight = element('input', { type: 'range', id: 'weight', min: '-100', max: '100' });
  weight.oninput = () => { times.textContent = `× ${weightAt(Number(weight.value))}`; };
  weight.onchange = () => {
    const { painted } = state.value;
    const chosen = weightAt(Number(weight.value));
    if (chosen !== painted.weight) state.set({ painted: { ...painted, weight: chosen } });
  };
  const costs = element('div', { className: 'stacked' },
    element('div', { className: 'labelled' }, element('label', { htmlFor: 'weight' }, 'Weight'), times), weight);
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
    costs,
    said,
    clear,
  );
  const show = () => {
    const { painted, curves, brush, erasing } = state.value;
    const inHand = state.value.tool === 'brush';
    const { surface, offers } = results.value;
    const count = countOf(painted);
    root.hidden = !inHand && !count;
    tool.hidden = !inHand;
    does.set(erasing ? 'erase' : 'paint');
    does.enable('erase', count > 0);
    means.set(painted.as);
    means.enable('weights', offers.costs && !curves.length); // least costs begin at points
    costs.hidden = painted.as !== 'weights';
    weight.value = `${placeOf(painted.weight)}`;
    times.textContent = `× ${painted.weight}`;
    size.value = `${100 * Math.sqrt(brush)}`;
    radius.textContent = surface ? lengthText(brush * surface.radius) : '';
    const meaning = {
      forbid: 'forbidden: every answer is without the hatched ones',
      within: 'left: every answer is without the hatched ones',
      weights: `weighted: on the hatched ones each length costs ${painted.weight} times as much`,
    }[painted.as];
    said.textContent = count && surface ? `${countText(count)} of ${countText(surface.about.faces)} faces ${meaning}` : '';
    clear.hidden = !count;
  };
  state.listen((now, before) => {
    // Where no paint is left, there is none to take away.
    if (now.erasing && !now.painted.faces.length) return state.set({ erasing: false });
    if (differ(now, before, 'tool', 'painted', 'curves', 'brush', 'erasing')) show();
  });
  results.listen((now, before) => differ(now, before, 'surface', 'offers') && show());
  show();
  return root;
}

/** The slider's places are on a scale of powers; weights have two digits. */
function weightAt(place: number): number {
  return Number((place < 0 ? LEAST_WEIGHT ** (-place / 100) : MOST_WEIGHT ** (place / 100)).toPrecision(2));
}

function placeOf(weight: number): number {
  return Math.round(weight < 1 ? (-100 * Math.log(weight)) / Math.log(LEAST_WEIGHT) : (100 * Math.log(weight)) / Math.log(MOST_WEIGHT));
}
