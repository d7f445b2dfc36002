/** A question over the page: answered by its button or Enter, left by Escape or the other button. */
import { element } from './element.ts';

export interface Question {
  readonly title: string;
  /** What is to be known before one answers. */
  readonly text?: string;
  /** A line to be typed; `run` gets it without blanks around it. */
  readonly input?: {
    readonly label: string;
    readonly properties?: Partial<Omit<HTMLInputElement, 'style' | 'children' | 'dataset' | 'role'>>;
    /** Why a line cannot be taken, in a sentence; empty where it can. The question then stays open. */
    readonly fault?: (typed: string) => string;
  };
  readonly yes: string;
  /** Whether to answer it takes something away that does not come back. */
  readonly grave?: boolean;
  readonly run: (typed: string) => void;
}

export function ask({ title, text, input, yes, grave, run }: Question): void {
  const line = input && element('input', { type: 'text', autocomplete: 'off', ...input.properties });
  const judge = () => line?.setCustomValidity(input?.fault?.(line.value.trim()) ?? '');
  line?.addEventListener('input', judge);
  judge();
  const cancel = element('button', { type: 'button', onclick: () => dialog.close() }, 'Cancel');
  const dialog = element(
    'dialog',
    { className: 'dialog', aria: { label: title } },
    element(
      'form',
      { method: 'dialog', onsubmit: () => run(line?.value.trim() ?? '') },
      element('h2', null, title),
      text && element('p', null, text),
      line && element('label', { className: 'stacked' }, input.label, line),
      element('div', { className: 'row answers' }, cancel, element('button', { type: 'submit', className: grave ? 'grave' : 'primary' }, yes)),
    ),
  );
  dialog.onclose = () => dialog.remove();
  document.body.append(dialog);
  dialog.showModal();
  // What cannot be taken back is not answered by a stray Enter.
  if (grave) cancel.focus();
  else if (line) line.select();
}
