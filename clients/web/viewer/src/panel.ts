/**
 * The panel's frame: a slim column on wide screens, a sheet at the bottom on narrow ones,
 * either way to be folded to its head. The stage is told what it covers.
 */
import { element, icon } from './element.ts';

const CHEVRON = 'M5 8l5 5 5-5';
const CROSS = 'M6 6l8 8M14 6l-8 8';
const NARROW = matchMedia('(max-width: 720px)');

export interface PanelButton {
  readonly label: string;
  readonly icon: string;
  run(): void;
  /** To be told whether it can be pressed. */
  follow?(enable: (on: boolean) => void): void;
}

export class Panel {
  readonly #root: HTMLElement;
  readonly #fold: HTMLButtonElement;

  constructor(
    buttons: readonly PanelButton[],
    parts: readonly HTMLElement[],
    private readonly covers: (right: number, bottom: number) => void,
  ) {
    this.#fold = element(
      'button',
      { type: 'button', className: 'round fold', onclick: () => this.toggle(), aria: { expanded: 'true', label: 'Panel' } },
      icon(CHEVRON),
    );
    const head = element(
      'header',
      { className: 'head' },
      element('h1', null, 'geodesic', element('b', null, 'd')),
      ...buttons.map(({ label, icon: drawing, run, follow }) => {
        const button = element('button', { type: 'button', className: 'round', title: label, onclick: run, aria: { label } }, icon(drawing));
        follow?.((on) => { button.disabled = !on; });
        return button;
      }),
      this.#fold,
    );
    const body = element('div', { className: 'body', tabIndex: 0, role: 'region', aria: { label: 'Settings' } }, ...parts);
    this.#root = element('main', { className: 'panel' }, head, body);
    document.body.append(this.#root);
    new ResizeObserver(() => this.#measure()).observe(this.#root);
    NARROW.addEventListener('change', () => this.#measure());
    this.#measure();
  }

  toggle(): void {
    const folded = this.#root.classList.toggle('folded');
    this.#fold.setAttribute('aria-expanded', `${!folded}`);
    this.#measure();
  }

  #measure(): void {
    const folded = this.#root.classList.contains('folded');
    const { width, height } = this.#root.getBoundingClientRect();
    if (NARROW.matches) this.covers(0, height);
    else this.covers(folded ? 0 : width + 16, 0);
  }
}

/** A part of the panel that can be folded, with its heading. */
export function part(title: string, open: boolean, ...children: (Node | null)[]): HTMLDetailsElement {
  return element(
    'details',
    { className: 'part', open },
    element('summary', null, element('h2', null, title), icon(CHEVRON)),
    element('div', { className: 'inside' }, ...children),
  );
}

/** One of a few, as a row of buttons that are radio buttons underneath. */
export function choice<Value extends string>(
  legend: string,
  options: readonly { value: Value; label: string; icon?: string; title?: string }[],
  chosen: (value: Value) => void,
): { root: HTMLFieldSetElement; set(value: Value): void; enable(value: Value, on: boolean): void } {
  const name = `choice-${legend.toLowerCase().replaceAll(' ', '-')}`;
  const inputs = new Map<Value, HTMLInputElement>();
  const root = element(
    'fieldset',
    { className: 'choice' },
    element('legend', { className: 'out-of-sight' }, legend),
    ...options.map(({ value, label, icon: drawing, title }) => {
      const input = element('input', { type: 'radio', name, value, onchange: () => chosen(value) });
      inputs.set(value, input);
      return element('label', title ? { title } : {}, input, element('span', null, drawing ? icon(drawing) : null, label));
    }),
  );
  return {
    root,
    set: (value) => {
      const input = inputs.get(value);
      if (input) input.checked = true;
      else for (const each of inputs.values()) each.checked = false;
    },
    enable: (value, on) => {
      const input = inputs.get(value);
      if (input) input.disabled = !on;
    },
  };
}

/** A button that takes something away. */
export function removeButton(what: string, remove: () => void): HTMLButtonElement {
  return element('button', { type: 'button', className: 'remove', onclick: remove, aria: { label: `Remove ${what}` } }, icon(CROSS));
}
