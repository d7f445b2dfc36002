/** The panel's choice of what paths minimise: their length, or time or energy on foot, by the slope of the ground. */
import { ONLY_STEINER } from './costs.ts';
import { element } from './element.ts';
import { choice } from './panel.ts';
import type { Parts } from './parts.ts';
import { byCost, differ, type Axis } from './state.ts';
import { upOf } from './upright.ts';

export function costPart({ state, results }: Parts): HTMLElement {
  const least = choice(
    'What paths minimise',
    [
      { value: 'length', label: 'Shortest', title: 'Distances and paths by length' },
      { value: 'tobler', label: 'Quickest', title: 'Seconds on foot by the slope, where lengths are metres (Tobler). The method is Steiner then' },
      { value: 'energy', label: 'Least energy', title: 'What walking takes by the slope, where lengths are metres (Minetti). The method is Steiner then' },
    ] as const,
    (by) => state.set({ walking: by === 'length' ? null : { by, up: upNow() } }),
  );
  const heights = choice<Axis>(
    'Axis of the heights',
    [
      { value: 'y', label: 'Y', title: 'Slopes are against Y, which is up' },
      { value: 'z', label: 'Z', title: 'Slopes are against Z, which is up' },
      { value: 'x', label: 'X', title: 'Slopes are against X, which is up' },
    ],
    (up) => {
      const { walking } = state.value;
      if (walking) state.set({ walking: { ...walking, up } });
    },
  );
  const alongAxis = element('div', { className: 'labelled heights' }, element('span', null, 'Heights along'), heights.root);
  const said = element('p', { className: 'facts' });
  const warnings = element('ul', { className: 'warnings' });
  const root = element('div', { className: 'stacked costs' }, least.root, alongAxis, said, warnings);
  /** As the view has it, unless other heights were chosen. */
  const upNow = (): Axis => {
    const { walking, up } = state.value;
    const about = results.value.surface?.about;
    return walking?.up ?? up ?? (about ? upOf(about) : 'y');
  };
  const show = () => {
    const { walking, curves } = state.value;
    const { offers, surface, field } = results.value;
    root.hidden = !offers.costs && !walking;
    // The surface says which way is up.
    for (const by of ['tobler', 'energy'] as const) least.enable(by, !curves.length && surface !== null);
    said.textContent = curves.length ? 'Least costs begin at points, not at lines.' : byCost(state.value) ? `${ONLY_STEINER}.` : '';
    said.hidden = !said.textContent;
    const warned = (field?.cost && field.warnings) || [];
    warnings.hidden = !warned.length;
    warnings.replaceChildren(...warned.map((text) => element('li', null, text)));
    least.set(walking?.by ?? 'length');
    alongAxis.hidden = !walking;
    if (walking) heights.set(walking.up);
  };
  state.listen((now, before) => differ(now, before, 'walking', 'curves', 'painted') && show());
  results.listen((now, before) => differ(now, before, 'offers', 'surface', 'field') && show());
  show();
  return root;
}
