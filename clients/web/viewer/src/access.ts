/**
 * The client of this page's server, and the token for one that asks for it: typed in
 * once, kept for as long as the tab lives, sent in its header and nowhere else.
 */
import { GeodesicClient, GeodesicError } from 'geodesicd-client';
import { ask } from './dialog.ts';
import { Kept } from './storage.ts';

const KEPT = new Kept('sessionStorage', 'geodesicd-token');
/** What a header carries of a token; a blank or an invisible character comes along with what is pasted. */
const TOKEN = /^[\x21-\x7e]+$/;

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
    if (!TOKEN.test(KEPT.value ?? '')) KEPT.value = null;
    const token = KEPT.value;
    // Beside the page, which need not be at the root of its host.
    return new GeodesicClient(new URL('.', location.href).href, { retries, maxRetryWait: 5000, ...(token ? { token } : {}) });
  }

  /** What can be done about an error by a token; undefined where nothing. */
  remedy(error: unknown): { label: string; run(): void } | undefined {
    if (!(error instanceof GeodesicError) || (error.status !== 401 && error.status !== 403)) return undefined;
    return { label: 'Enter a token', run: () => this.#ask() };
  }

  #ask(): void {
    ask({
      title: 'Token',
      input: {
        label: 'As whoever runs the server gave it to you',
        properties: { type: 'password', required: true, name: 'token' },
        fault: (typed) => (TOKEN.test(typed) ? '' : 'A token has only letters, digits and signs of ASCII, and no blanks. Copy it again.'),
      },
      yes: 'Use it',
      run: (token) => {
        KEPT.value = token;
        this.client = this.#make(2);
        this.probe = this.#make(0);
        this.#changed();
      },
    });
  }
}
