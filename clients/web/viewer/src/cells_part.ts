/** The panel's list of cells: the area that is nearest to each source, and sources into their middles. */
import { element } from './element.ts';
import { countText, lengthText } from './numbers.ts';
import type { Parts } from './parts.ts';
import { hueOf } from './regions.ts';
import { differ } from './state.ts';
import { unitOf } from './units.ts';

/** Rows of cells, unless all are asked for. */
const LISTED = 8;

export function cellsPart({ state, results, actions }: Parts): HTMLElement {
  const rows = element('tbody', null);
  const unit = element('small', null);
  const table = element(
    'table',
    { className: 'areas' },
    element('thead', null, element('tr', null,
      element('th', { scope: 'col' }, 'Cell'),
      element('th', { scope: 'col' }, 'Area', unit),
      element('th', { scope: 'col' }, 'Border', element('small', null, 'with others')))),
    rows,
  );
  const relax = element('button', { type: 'button', onclick: actions.relax, title: 'Moves each source towards the middle of its cell, five times' }, 'Relax');
  const more = element('button', { type: 'button', className: 'quiet' });
  const sum = element('p', { className: 'facts', role: 'status' });
  const root = element('section', { className: 'answer cells-part', hidden: true },
    element('div', { className: 'row' }, element('h2', null, 'Cells'), relax), sum, table, more);
  let all = false;
  more.onclick = () => {
    all = !all;
    show();
  };
  const show = () => {
    const { cells, surface, regions } = results.value;
    root.hidden = state.value.show !== 'cells';
    if (root.hidden) return;
    const answered = cells?.answered.cells ?? [];
    table.hidden = answered.length === 0;
    more.hidden = answered.length <= LISTED;
    more.textContent = all ? `Only the first ${LISTED}` : `and ${answered.length - LISTED} more`;
    more.setAttribute('aria-expanded', `${all}`);
    relax.disabled = !cells;
    const total = answered.reduce((before, { area }) => before + area, 0);
    const named = surface ? unitOf(surface.about) : '';
    unit.textContent = named ? `${named}²` : '';
    sum.textContent = cells ? `${countText(answered.length)} cells with ${lengthText(total)}${named && ` ${named}²`} in all` : '…';
    rows.replaceChildren(
      ...answered.slice(0, all ? answered.length : LISTED).map(({ area, perimeter }, index) => {
        const colour = element('i', { aria: { hidden: 'true' } });
        colour.style.setProperty('--hue', hueOf(regions, index));
        return element('tr', null,
          element('th', { scope: 'row' }, colour, `${index + 1}`),
          element('td', { className: 'area' }, lengthText(area)),
          element('td', null, lengthText(perimeter)));
      }),
    );
  };
  state.listen((now, before) => now.show !== before.show && show());
  results.listen((now, before) => {
    if (differ(now, before, 'cells', 'regions', 'surface')) show();
  });
  show();
  return root;
}
