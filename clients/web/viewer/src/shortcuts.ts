/** Keys that work everywhere on the page, and the sheet that lists them, by `?`. */
import { element, icon } from './element.ts';

export interface Shortcut {
  readonly keys: string;
  readonly does: string;
  /** Absent for what the canvas or the pointer does by itself. */
  readonly run?: () => void;
}

const CROSS = 'M5 5l10 10M15 5L5 15';

/** Whether keys belong to what has the focus. */
function typing(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement) return !['radio', 'checkbox', 'range'].includes(target.type);
  return target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement;
}

/** Listens for the shortcuts; the returned function shows the sheet. */
export function shortcuts(groups: readonly { title: string; keys: readonly Shortcut[] }[]): () => void {
  const runs = new Map<string, () => void>();
  for (const { keys } of groups) for (const { keys: key, run } of keys) if (run) runs.set(key.toLowerCase(), run);

  const sheet = element(
    'dialog',
    { className: 'dialog wide', aria: { label: 'Keys and gestures' } },
    element('form', { method: 'dialog', className: 'close' },
      element('button', { className: 'round', aria: { label: 'Close' } }, icon(CROSS))),
    element('h2', null, 'Keys and gestures'),
    element(
      'div',
      { className: 'key-groups' },
      ...groups.map(({ title, keys }) =>
        element(
          'section',
          null,
          element('h3', null, title),
          element('dl', null, ...keys.flatMap(({ keys: key, does }) => [
            element('dt', null, ...key.split(' ').map((each) => element('kbd', null, each))),
            element('dd', null, does),
          ])),
        ),
      ),
    ),
    // Relative: the page may stand under a path.
    element('p', null, element('a', { href: 'docs/' }, 'The guide'), ' says more of the page and of the API.'),
  );
  document.body.append(sheet);
  // A click beside it closes it.
  sheet.addEventListener('click', (event) => { if (event.target === sheet) sheet.close(); });

  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented || event.isComposing) return;
    if (typing(event.target) && event.key !== 'Escape') return;
    if (document.querySelector('dialog[open]')) return;
    const run = runs.get(event.key.toLowerCase());
    if (!run) return;
    event.preventDefault();
    run();
  });
  return () => sheet.showModal();
}
