/** How files are read: for those to come, and for the mesh that is shown, again. */
import type { Reading } from 'geodesicd-client';
import { element } from './element.ts';
import type { Parts } from './parts.ts';

export interface ImportPart {
  readonly root: HTMLElement;
  /** What is wished for the next file. */
  readonly reading: () => Reading;
}

export function importPart({ results, actions }: Pick<Parts, 'results' | 'actions'>): ImportPart {
  const field = (id: string, name: string, title: string, input: HTMLElement) =>
    element('div', { className: 'labelled', title }, element('label', { htmlFor: id }, name), input);
  const scale = element('input', { type: 'text', id: 'import-scale', inputMode: 'decimal', autocomplete: 'off', placeholder: '1' });
  const weld = element('input', { type: 'text', id: 'import-weld', autocomplete: 'off', placeholder: '0' });
  const up = element(
    'select',
    { id: 'import-up' },
    ...(['y', 'z', 'x'] as const).map((axis) => element('option', { value: axis }, axis === 'y' ? 'y, as it stands' : `${axis}: turn it`)),
  );
  const said = element('p', { className: 'facts' });
  const again = element('button', { type: 'button', onclick: () => actions.readAgain(reading()) }, 'Read this mesh again');
  const root = element(
    'details',
    { className: 'import' },
    element('summary', null, 'Import options'),
    element(
      'div',
      { className: 'inside' },
      field('import-scale', 'Scale', 'All positions times this: 0.001 makes metres of millimetres', scale),
      field('import-weld', 'Join vertices within', 'A distance; off: none are joined, not even equal ones', weld),
      field('import-up', 'Axis up in the file', 'The server turns the mesh so that y is up', up),
      said,
      again,
    ),
  );
  function reading(): Reading {
    const factor = Number(scale.value.replace(',', '.'));
    const near = weld.value.trim();
    return {
      scale: scale.value.trim() && factor > 0 && factor !== 1 ? factor : undefined,
      weld: near === 'off' ? 'off' : near && Number(near) > 0 ? Number(near) : undefined,
      up: up.value === 'y' ? undefined : (up.value as 'x' | 'z'),
    };
  }
  const follow = () => {
    said.textContent = Object.values(reading()).some((value) => value !== undefined) ? 'Files that you open now are read like this, too.' : '';
    again.disabled = results.value.surface === null;
  };
  for (const each of [scale, weld, up]) each.oninput = follow;
  results.listen((now, before) => now.surface !== before.surface && follow());
  follow();
  return { root, reading };
}
