/**
 * A server that is gone and comes back: a banner while it is away, questions whether it is
 * there at growing intervals, and then a word to all who wait to go on.
 */
import { GeodesicError, NetworkError, type GeodesicClient } from 'geodesicd-client';
import type { Notices } from './notices.ts';

const LONGEST = 8; // seconds between two questions

export class Connection {
  #lost = false;
  #timer = 0;
  #wait = 1;
  readonly #back: (() => void)[] = [];

  /** `client` must not retry by itself: this does, and says so. */
  constructor(
    private readonly client: () => GeodesicClient,
    private readonly notices: Notices,
  ) {
    addEventListener('online', () => this.#lost && this.#ask());
    addEventListener('offline', () => this.explains(new NetworkError('', 'offline')));
  }

  get lost(): boolean {
    return this.#lost;
  }

  onBack(listener: () => void): void {
    this.#back.push(listener);
  }

  /** Whether an error means that the server is not there; if so, the wait for it begins. */
  explains(error: unknown): boolean {
    const gone = error instanceof NetworkError || (error instanceof GeodesicError && error.code === 'draining');
    if (gone && !this.#lost) {
      this.#lost = true;
      this.#wait = 1;
      this.#schedule();
    }
    return gone;
  }

  #schedule(): void {
    let left = Math.ceil(this.#wait);
    const tick = () => {
      if (left <= 0) return void this.#ask();
      this.notices.banner(`The server does not answer. Next try in ${left} s; what you see stays.`, {
        label: 'Try now',
        run: () => void this.#ask(),
      });
      left--;
      this.#timer = window.setTimeout(tick, 1000);
    };
    tick();
  }

  async #ask(): Promise<void> {
    clearTimeout(this.#timer);
    this.notices.banner('Asking the server …');
    try {
      const { draining } = await this.client().status();
      if (draining) throw new NetworkError('', 'about to stop');
    } catch (error) {
      // A server that asks for a token is there.
      if (error instanceof NetworkError || (error instanceof GeodesicError && error.status >= 500)) {
        this.#wait = Math.min(LONGEST, this.#wait * 1.6);
        this.#schedule();
        return;
      }
    }
    this.#lost = false;
    this.notices.banner(null);
    for (const listener of this.#back) listener();
  }
}
