/** The panel's part for the answer: how long the path is, by which method, in what time. */
import { element } from './element.ts';
import { lengthText, timeText } from './numbers.ts';
import type { Parts } from './parts.ts';
import { nameOf } from './questions.ts';
import { differ } from './state.ts';
import { unitOf } from './units.ts';
import { costKind, costOfUnit, SAID } from './costs.ts';

export function resultPart({ state, results, actions }: Parts): HTMLElement {
  const big = element('output', { className: 'big', id: 'length' });
  const unit = element('span', { className: 'unit' });
  const sub = element('p', { className: 'facts' });
  const keep = element('button', { type: 'button', onclick: actions.keep, title: 'Into the list of measures (K)' }, 'Keep');
  const title = element('h2', null, 'Shortest path');
  const root = element(
    'section',
    { className: 'result', hidden: true },
    title,
    element('div', { className: 'row' }, element('div', { className: 'number' }, big, unit), keep),
    sub,
  );
  const show = () => {
    const { target, sources, curves } = state.value;
    const cost = costKind(state.value);
    const { path, pathMs } = results.value;
    root.hidden = !target;
    title.textContent = cost ? SAID[cost].title : 'Shortest path';
    // What is kept is short, and begins at a point.
    keep.hidden = !path?.reachable || curves.length > 0 || cost !== null;
    if (!target) return;
    if (!sources.length && !curves.length) {
      big.textContent = '–';
      unit.textContent = '';
      sub.textContent = 'Place a source: the path begins there.';
    } else if (!path) {
      big.textContent = '…';
      unit.textContent = '';
      sub.textContent = '';
    } else if (!path.reachable) {
      big.textContent = '∞';
      unit.textContent = '';
      sub.textContent = 'The target lies on another component: no path leads there.';
    } else {
      big.textContent = lengthText(path.length!);
      const about = results.value.surface?.about;
      unit.textContent = about ? unitOf(about) : '';
      const said = [nameOf(path.method)];
      // Of what was answered, which may be a moment behind the state.
      if (path.cost != null) said.unshift(SAID[costOfUnit(path.unit)].text(path.cost));
      if (path.refine === 'shortest') said.push('pulled straight');
      if (path.via.length) said.push(path.via.length === 1 ? 'via 1 point' : `via ${path.via.length} points`);
      if (pathMs !== null) said.push(timeText(pathMs));
      sub.textContent = said.join(' · ');
    }
  };
  state.listen((now, before) => differ(now, before, 'target', 'sources', 'curves', 'walking', 'painted') && show());
  results.listen((now, before) => {
    if (now.path !== before.path) show();
    root.classList.toggle('stale', now.stale);
    keep.disabled = now.stale;
  });
  show();
  return root;
}
