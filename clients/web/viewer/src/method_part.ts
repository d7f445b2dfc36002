/**
 * The panel's part for methods: which one computes, what time each took for the present
 * sources, and its mean error against the exact method where that is known.
 */
import { element } from './element.ts';
import { shareText, timeText } from './numbers.ts';
import { part } from './panel.ts';
import type { Parts } from './parts.ts';
import { nameOf } from './questions.ts';

export function methodPart({ state, results, actions }: Parts): HTMLElement {
  const list = element('div', { className: 'methods', role: 'radiogroup', aria: { label: 'Method' } });
  const extra = element('div', { className: 'labelled', hidden: true });
  const perEdge = element('input', { type: 'range', id: 'per-edge', min: '1', max: '12' });
  const perEdgeValue = element('output', null);
  extra.append(element('label', { htmlFor: 'per-edge' }, 'Points per edge'), perEdge, perEdgeValue);
  perEdge.onchange = () => state.set({ pointsPerEdge: Number(perEdge.value) });
  perEdge.oninput = () => { perEdgeValue.textContent = perEdge.value; };
  const refine = element('input', { type: 'checkbox', id: 'refine' });
  refine.onchange = () => state.set({ refine: refine.checked });
  const compare = element('button', { type: 'button', onclick: actions.compare }, 'Compare all');
  const root = part(
    'Method',
    true,
    list,
    extra,
    element('label', { className: 'check', htmlFor: 'refine' }, refine, 'Pull the path straight'),
    compare,
  );
  const rows = new Map<string, { input: HTMLInputElement; time: HTMLElement; error: HTMLElement }>();

  const fill = () => {
    rows.clear();
    list.replaceChildren(
      ...results.value.methods.map(({ name, paper, exact }) => {
        const input = element('input', { type: 'radio', name: 'method', value: name, onchange: () => state.set({ method: name }) });
        const time = element('span', { className: 'time' });
        const error = element('span', { className: 'error' });
        rows.set(name, { input, time, error });
        return element(
          'label',
          { title: paper },
          input,
          element('span', { className: 'name' }, nameOf(name), exact ? element('em', null, 'exact') : null),
          error,
          time,
        );
      }),
    );
    follow();
  };
  const follow = () => {
    const { method, sources, pointsPerEdge } = state.value;
    for (const [name, { input, time, error }] of rows) {
      const trial = results.value.trials[name];
      input.checked = name === method;
      time.textContent = !trial ? '' : trial.ms === null ? 'kept' : timeText(trial.ms);
      time.title = trial?.ms === null ? 'The server had this field already' : '';
      error.textContent = trial?.mean == null ? '' : shareText(trial.mean);
      error.title = trial?.most == null ? '' : `Mean error; at most ${shareText(trial.most)}`;
    }
    const steiner = results.value.methods.find(({ name }) => name === method)?.parameters.find(({ name }) => name === 'points_per_edge');
    extra.hidden = !steiner;
    perEdge.value = `${pointsPerEdge ?? steiner?.default ?? 3}`;
    perEdgeValue.textContent = perEdge.value;
    refine.checked = state.value.refine;
    compare.disabled = sources.length === 0;
  };
  state.listen(follow);
  results.listen((now, before) => {
    if (now.methods !== before.methods) fill();
    else if (now.trials !== before.trials) follow();
  });
  fill();
  return root;
}
