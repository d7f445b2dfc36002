/** The panel's list of kept paths: lengths to compare, to show again and to take away. */
import { element } from './element.ts';
import { lengthText } from './numbers.ts';
import { letterOf } from './measures.ts';
import { part, removeButton } from './panel.ts';
import type { Parts } from './parts.ts';
import { nameOf } from './questions.ts';
import type { Measure } from './state.ts';

export function measureList({ state, results, actions }: Parts): HTMLElement {
  const list = element('ol', { className: 'measures' });
  const none = element('p', { className: 'facts' }, 'Keep a path to compare it with others.');
  const csv = element('button', { type: 'button', className: 'quiet', onclick: () => actions.exported('measures.csv') }, 'Save as CSV');
  const root = part('Measures', false, none, list, csv);

  const back = ({ from, via, to, method, pointsPerEdge, refine, painted }: Measure) =>
    state.set({ sources: [from], curves: [], via, target: to, method, ...(method === 'steiner' && { pointsPerEdge }), refine, painted, walking: null, tool: 'target' });
  const show = () => {
    const { measures } = state.value;
    none.hidden = measures.length > 0;
    csv.hidden = measures.length === 0;
    list.replaceChildren(
      ...measures.map((measure, index) => {
        const path = results.value.measured[index];
        const length = !path ? '…' : path.reachable ? lengthText(path.length!) : '∞';
        const letter = letterOf(index);
        return element(
          'li',
          null,
          element(
            'button',
            { type: 'button', className: 'measure', title: 'Show it again', onclick: () => back(measure) },
            element('b', null, letter),
            element('span', { className: 'number' }, length),
            element('small', null, nameOf(measure.method)),
          ),
          removeButton(`measure ${letter}`, () => state.set({ measures: state.value.measures.filter((other) => other !== measure) })),
        );
      }),
    );
  };
  state.listen((now, before) => {
    if (now.measures === before.measures) return;
    if (now.measures.length > before.measures.length) root.open = true;
    show();
  });
  results.listen((now, before) => now.measured !== before.measured && show());
  if (state.value.measures.length) root.open = true;
  show();
  return root;
}
