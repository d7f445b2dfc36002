/**
 * What the page says about its work, above the mesh and below: errors with advice, the
 * banner of a lost server, hints, and the progress of long work with a way to stop it.
 */
import { element, icon } from './element.ts';
import type { Trouble } from './messages.ts';

const CROSS = 'M5 5l10 10M15 5L5 15';
/** Milliseconds before progress is shown: what is over sooner would only flicker. */
const PATIENCE = 350;
/** The same for what is mostly over at once, so that to show it is to say that something is slow. */
export const SLOW = 2500;

/** A piece of work that is under way. */
export interface Progress {
  /** `done` from 0 to 1, undefined where nobody knows. */
  say(what: string, done?: number): void;
  end(): void;
}

export class Notices {
  readonly #troubles = element('div', { className: 'troubles', role: 'alert' });
  readonly #banner = element('div', { className: 'banner', role: 'status', hidden: true });
  readonly #works = element('div', { className: 'works' });
  readonly #hint = element('p', { className: 'hint', role: 'status', hidden: true });
  #under = 0;

  constructor() {
    document.body.append(
      element('div', { className: 'notices', role: 'region', aria: { label: 'Messages' } }, this.#banner, this.#troubles),
      element('div', { className: 'under-way', role: 'region', aria: { label: 'Work under way' } }, this.#hint, this.#works),
    );
  }

  /** Shows an error until it is closed; the same error is shown once. `action` is a button more. */
  trouble(trouble: Trouble, action?: { label: string; run(): void }): void {
    this.#show(trouble, 'trouble', action);
  }

  /** Shows in the same place what is no error, but may not be what was meant. */
  remark(remark: Trouble, action?: { label: string; run(): void }): void {
    this.#show(remark, 'trouble remark', action);
  }

  #show({ title, advice, detail, about }: Trouble, className: string, action?: { label: string; run(): void }): void {
    for (const shown of this.#troubles.children) {
      if (shown.querySelector('strong')?.textContent === title) shown.remove();
    }
    const close = () => card.remove();
    const card = element(
      'div',
      { className },
      element('div', null, element('strong', null, title), element('p', null, advice), detail ? element('small', null, detail) : null),
      action && element('button', { type: 'button', onclick: () => { close(); action.run(); } }, action.label),
      element('button', { type: 'button', className: 'round', onclick: close, aria: { label: 'Close this message' } }, icon(CROSS)),
    );
    if (about) card.dataset['about'] = about;
    this.#troubles.append(card);
    while (this.#troubles.children.length > 3) this.#troubles.firstElementChild!.remove();
  }

  clearTroubles(): void {
    this.#troubles.replaceChildren();
  }

  /** What was wrong about this has gone well now: its messages are out of date. */
  settle(about: string): void {
    for (const shown of [...this.#troubles.children] as HTMLElement[]) if (shown.dataset['about'] === about) shown.remove();
  }

  /** Whether there is work that the reader sees or soon will. */
  get working(): boolean {
    return this.#under > 0;
  }

  /** The line over everything, for as long as it holds; null takes it away. */
  banner(text: string | null, action?: { label: string; run(): void }): void {
    this.#banner.hidden = text === null;
    if (text === null) return;
    this.#banner.replaceChildren(
      element('span', null, text),
      ...(action ? [element('button', { type: 'button', onclick: action.run }, action.label)] : []),
    );
  }

  hint(text: string | null): void {
    this.#hint.hidden = text === null;
    if (text !== null && this.#hint.textContent !== text) this.#hint.textContent = text;
  }

  /** Shows work with a bar once it has taken so many milliseconds; `cancel` makes a button that stops it. */
  begin(what: string, cancel?: () => void, after = PATIENCE): Progress {
    const bar = element('progress', { max: 1, aria: { label: what } });
    const name = element('span', null, what);
    const share = element('span', { className: 'share' });
    const card = element(
      'div',
      { className: 'work' },
      element('div', { className: 'work-line' }, name, share),
      bar,
      cancel && element('button', { type: 'button', className: 'cancel', onclick: cancel }, 'Cancel'),
    );
    const timer = setTimeout(() => this.#works.append(card), after);
    this.#under++;
    let ended = false;
    return {
      say: (now, done) => {
        name.textContent = now;
        share.textContent = done === undefined ? '' : `${Math.floor(100 * done)} %`;
        if (done === undefined) bar.removeAttribute('value');
        else bar.value = done;
      },
      end: () => {
        if (!ended) this.#under--;
        ended = true;
        clearTimeout(timer);
        card.remove();
      },
    };
  }
}
