/**
 * The client of this page's server, and the token for one that asks for it: typed in
 * once, kept for as long as the tab lives, sent in its header and nowhere else.
 */
import { GeodesicClient, GeodesicError } from 'geodesicd-client';
import { element } from './element.ts';

const KEPT = 'geodesicd-token';

export class Access {
  client = this.#make(2);
  /** Without retries: for asking whether the server is there. */
  probe = this.#make(0);
  readonly #changed: () => void;

  /** `changed` is called when there is a new token. */
  constructor(changed: () => void) {
    this.#changed = changed;
  }

  #make(retries: number): GeodesicClient {
    const token = sessionStorage.getItem(KEPT);
    return new GeodesicClient(undefined, { retries, maxRetryWait: 5000, ...(token ? { token } : {}) });
  }

  /** What can be done about an error by a token; undefined where nothing. */
  remedy(error: unknown): { label: string; run(): void } | undefined {
    if (!(error instanceof GeodesicError) || (error.status !== 401 && error.status !== 403)) return undefined;
    return { label: 'Enter a token', run: () => this.#ask() };
  }

  #ask(): void {
    const input = element('input', { type: 'password', autocomplete: 'off', required: true, name: 'token' });
    const dialog = element(
      'dialog',
      { className: 'dialog', aria: { label: 'Token' } },
      element(
        'form',
        {
          method: 'dialog',
          onsubmit: () => {
            sessionStorage.setItem(KEPT, input.value.trim());
            this.client = this.#make(2);
            this.probe = this.#make(0);
            this.#changed();
          },
        },
        element('h2', null, 'Token'),
        element('label', { className: 'stacked' }, 'As whoever runs the server gave it to you', input),
        element('div', { className: 'row' }, element('button', { type: 'submit', className: 'primary' }, 'Use it')),
      ),
    );
    dialog.onclose = () => dialog.remove();
    document.body.append(dialog);
    dialog.showModal();
  }
}
