/**
 * The panel's part for methods: which one computes, with the server's own words for each, and a
 * table of what each took for the present sources, with its error where the exact distances are known.
 */
import { costPart } from './cost_part.ts';
import { methodUsed } from './costs.ts';
import { element } from './element.ts';
import { part } from './panel.ts';
import type { Parts } from './parts.ts';
import { nameOf } from './questions.ts';
import { byCost } from './state.ts';

export function methodPart(parts: Parts): HTMLElement {
  const { state, results, actions } = parts;
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
  const rows = element('tbody', null);
  const head = (name: string, unit: string) => element('th', { scope: 'col' }, name, element('small', null, unit));
  const table = element(
    'table',
    { className: 'compared', hidden: true },
    element('caption', null, 'For these sources, against Exact'),
    element('thead', null, element('tr', null, element('th', { scope: 'col' }, 'Method'), head('Time', 'ms'), head('Mean error', '%'), head('Largest', '%'))),
    rows,
  );
  const kept = element('p', { className: 'facts' }, '–: the server had these distances already.');
  const stopped = element('p', { className: 'facts', role: 'status' });
  const root = part(
    'Method',
    true,
    costPart(parts),
    list,
    element('p', { className: 'facts' }, element('a', { href: 'docs/methods/' }, 'All methods compared')),
    extra,
    element('label', { className: 'check', htmlFor: 'refine' }, refine, 'Pull the path straight'),
    compare,
    stopped,
    table,
    kept,
  );
  const inputs = new Map<string, HTMLInputElement>();

  const fill = () => {
    inputs.clear();
    list.replaceChildren(
      ...results.value.methods.map(({ name, about, paper, exact }) => {
        const input = element('input', {
          type: 'radio', name: 'method', value: name, onchange: () => state.set({ method: name }),
          aria: { describedby: `about-${name}` },
        });
        inputs.set(name, input);
        return element(
          'div',
          { className: 'method', title: paper },
          element('label', null, input, element('span', { className: 'name' }, nameOf(name), exact ? element('em', null, 'exact') : null)),
          element('p', { id: `about-${name}` }, about),
        );
      }),
    );
    follow();
  };
  const follow = () => {
    const { method, sources, curves, pointsPerEdge } = state.value;
    const used = methodUsed(state.value);
    const { trials, methods } = results.value;
    for (const [name, input] of inputs) input.checked = name === method;
    const tried = methods.filter(({ name }) => trials[name]);
    table.hidden = !tried.some(({ name }) => trials[name]!.ms !== null || trials[name]!.mean !== null);
    kept.hidden = table.hidden || tried.every(({ name }) => trials[name]!.ms !== null);
    stopped.textContent = results.value.stopped ? 'Stopped before all methods were compared.' : '';
    rows.replaceChildren(
      ...tried.map(({ name }) => {
        const { ms, mean, most } = trials[name]!;
        return element(
          'tr',
          name === method ? { className: 'chosen' } : null,
          element('th', { scope: 'row' }, nameOf(name)),
          element('td', { className: 'time' }, ms === null ? '–' : numberText(ms)),
          element('td', { className: 'error' }, percentText(mean)),
          element('td', { className: 'most' }, percentText(most)),
        );
      }),
    );
    const steiner = methods.find(({ name }) => name === used)?.parameters.find(({ name }) => name === 'points_per_edge');
    extra.hidden = !steiner;
    perEdge.value = `${pointsPerEdge ?? steiner?.default ?? 3}`;
    perEdgeValue.textContent = perEdge.value;
    refine.checked = state.value.refine;
    refine.disabled = byCost(state.value);
    for (const input of inputs.values()) input.disabled = byCost(state.value);
    compare.disabled = byCost(state.value) || sources.length + curves.length === 0;
  };
  state.listen(follow);
  results.listen((now, before) => {
    if (now.methods !== before.methods) fill();
    else if (now.trials !== before.trials || now.stopped !== before.stopped) follow();
  });
  fill();
  return root;
}

function numberText(ms: number): string {
  return ms < 10 ? ms.toFixed(1) : Math.round(ms).toLocaleString('en-GB');
}

/** Two digits that count; what is rounding only is 0. */
function percentText(share: number | null): string {
  if (share === null) return '–';
  const percent = 100 * share;
  return percent < 1e-4 ? (percent < 1e-9 ? '0' : '< 0.0001') : `${Number(percent.toPrecision(2))}`;
}
