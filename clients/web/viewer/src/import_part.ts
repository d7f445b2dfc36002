/** How files are read: for those to come, and for the mesh that is shown, again. */
import type { Reading } from 'geodesicd-client';
import { element } from './element.ts';
import type { Parts } from './parts.ts';

export interface ImportPart {
  readonly root: HTMLElement;
  /** What is wished for the next file; null, and told at the field, where that cannot be read. */
  readonly reading: () => Reading | null;
}

interface Option {
  readonly input: HTMLInputElement;
  readonly title: string;
  /** What may stand there. */
  readonly allowed: string;
  readonly fits: (text: string) => boolean;
}

const numberIn = (text: string) => (/^[-+]?(\d+[.,]?\d*|[.,]\d+)(e[-+]?\d+)?$/i.test(text) ? Number(text.replace(',', '.')) : NaN);
const between = (value: number, least: number, most: number) => value >= least && value <= most;

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
  const options: readonly Option[] = [
    {
      input: scale,
      title: 'Scale',
      allowed: 'a number above 0, such as 0.001',
      fits: (text) => between(numberIn(text), 1e-30, 1e30),
    },
    {
      input: weld,
      title: 'Join vertices within',
      allowed: 'a distance from 0 on, or off',
      fits: (text) => text === 'off' || numberIn(text) === 0 || between(numberIn(text), 1e-60, 1e60),
    },
  ];
  const said = element('p', { className: 'facts', id: 'import-said', role: 'status' });
  const again = element('button', { type: 'button', onclick: () => { const wish = reading(); if (wish) actions.readAgain(wish); } }, 'Read this mesh again');
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
  const wrong = () => options.filter(({ input, fits }) => input.value.trim() && !fits(input.value.trim()));
  function reading(): Reading | null {
    const [first] = wrong();
    if (first) {
      root.open = true;
      first.input.focus();
      return null;
    }
    const factor = scale.value.trim() ? numberIn(scale.value.trim()) : 1;
    const near = weld.value.trim();
    return {
      scale: factor === 1 ? undefined : factor,
      weld: near === 'off' ? 'off' : near && numberIn(near) > 0 ? numberIn(near) : undefined,
      up: up.value === 'y' ? undefined : (up.value as 'x' | 'z'),
    };
  }
  /** Whose reading the fields have. */
  let shown = '';
  const usual = () => !scale.value.trim() && !weld.value.trim() && up.value === 'y';
  const follow = () => {
    const faults = wrong();
    for (const option of options) {
      option.input.setAttribute('aria-invalid', `${faults.includes(option)}`);
      option.input.setAttribute('aria-describedby', 'import-said');
    }
    said.classList.toggle('wrong', faults.length > 0);
    if (faults.length) said.textContent = faults.map(({ title, allowed }) => `${title}: ${allowed}.`).join(' ');
    else said.textContent = usual() ? '' : 'Files that you open now are read like this, too.';
    again.disabled = results.value.surface === null || faults.length > 0;
  };
  for (const each of [scale, weld, up]) each.oninput = follow;
  results.listen((now, before) => {
    if (now.surface === before.surface) return;
    if (now.surface && now.surface.id !== shown) {
      // As the mesh that is seen was read, after a reload and by a link, too.
      shown = now.surface.id;
      const { import: read } = now.surface.about;
      scale.value = `${read.scale ?? ''}`;
      weld.value = read.weld ?? '';
      up.value = read.up ?? 'y';
      if (!usual()) root.open = true;
    }
    follow();
  });
  follow();
  return { root, reading };
}
