/** The panel's part for how the surface is painted. */
import { element } from './element.ts';
import { tickText } from './numbers.ts';
import { choice, part } from './panel.ts';
import type { Parts } from './parts.ts';
import { byCost, byRegion, mayHaveCells } from './state.ts';
import { lineStepOf } from './surface_view.ts';
import { upOf } from './upright.ts';

export function lookPart({ state, results, actions }: Parts): HTMLElement {
  const show = choice(
    'What colours show',
    [
      { value: 'distance', label: 'Distance' },
      { value: 'regions', label: 'Regions', title: 'Which source is nearest; needs two' },
      { value: 'cells', label: 'Cells', title: 'What is nearest to each source, with its borders and area; needs two' },
      { value: 'error', label: 'Error', title: 'Of the method, against the exact one' },
    ] as const,
    (value) => state.set({ show: value }),
  );
  const colours = choice(
    'Colour map',
    [
      { value: 'viridis', label: 'Viridis' },
      { value: 'turbo', label: 'Turbo' },
    ] as const,
    (value) => state.set({ colours: value }),
  );
  const lines = element('input', { type: 'range', id: 'lines', min: '0', max: '60', step: '1' });
  lines.oninput = () => state.set({ lines: Number(lines.value) });
  const apart = element('output', null);
  const ticks = element('input', { type: 'checkbox', id: 'ticks' });
  ticks.onchange = () => state.set({ ticks: ticks.checked });
  const edges = element('input', { type: 'checkbox', id: 'edges' });
  edges.onchange = () => state.set({ edges: edges.checked });
  const up = choice(
    'Axis that is up',
    [
      { value: 'y', label: 'Y up', title: 'As in glTF (U)' },
      { value: 'z', label: 'Z up', title: 'As in maps and most CAD programs (U)' },
      { value: 'x', label: 'X up', title: 'As in few files (U)' },
    ] as const,
    actions.turn,
  );
  const root = part(
    'Surface',
    true,
    show.root,
    colours.root,
    element('div', { className: 'labelled' }, element('label', { htmlFor: 'lines' }, 'Isolines'), apart),
    lines,
    element('label', { className: 'check', htmlFor: 'ticks' }, ticks, 'Distances along the path'),
    element('label', { className: 'check', htmlFor: 'edges' }, edges, 'Edges of the mesh'),
    element('div', { className: 'row view-row' }, up.root, element('button', { type: 'button', onclick: actions.fit, title: 'All of the mesh, as at first (F)' }, 'Reset view')),
  );
  const follow = () => {
    const now = state.value;
    const { field } = results.value;
    show.set(now.show);
    const count = now.sources.length + now.curves.length;
    show.enable('regions', count > 1);
    show.enable('cells', mayHaveCells(now));
    show.enable('error', count > 0 && !byCost(now));
    colours.set(now.colours);
    // Regions and errors have colours of their own.
    for (const map of ['viridis', 'turbo'] as const) colours.enable(map, now.show === 'distance');
    lines.value = `${now.lines}`;
    ticks.checked = now.ticks;
    edges.checked = now.edges;
    const { surface } = results.value;
    if (surface) up.set(now.up ?? upOf(surface.about));
    const step = lineStepOf(field?.max ?? 0, now.lines);
    apart.textContent = now.lines === 0 ? 'none' : step > 0 ? `every ${tickText(step)}` : '';
  };
  state.listen((now, before) => {
    // With one source left there are no regions to show.
    const few = now.sources.length + now.curves.length < 2 && before.sources.length + before.curves.length > 1;
    // What is about lengths goes where costs come; cells that wait for a second source stay.
    const cells = now.show === 'cells' && !mayHaveCells(now) && (mayHaveCells(before) || byCost(now));
    if ((byRegion(now.show) && few) || cells || (now.show === 'error' && byCost(now))) state.set({ show: 'distance' });
    else follow();
  });
  results.listen((now, before) => (now.field !== before.field || now.surface !== before.surface) && follow());
  follow();
  return root;
}
