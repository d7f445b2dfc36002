/**
 * A server that is gone and comes back: a banner while it is away, questions whether it is
 * there at growing intervals, and then a word to all who wait to go on. A request that fails
 * again although the server is there is told by itself: to go on would only fail once more.
 */
import { GeodesicError, NetworkError, type GeodesicClient } from 'geodesicd-client';
import type { Notices } from './notices.ts';

const LONGEST = 8; // seconds between two questions

export class Connection {
  #lost = false;
  #timer = 0;
  #wait = 1;
  /** Whether a question since the loss was in vain: then the server really was away. */
  #away = false;
  /** What failed since the loss, and what failed before although the server was there. */
  readonly #failed = new Set<string>();
  readonly #suspects = new Set<string>();
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
    if (!gone) return false;
    if (error instanceof NetworkError && error.url) this.#failed.add(error.url);
    if (this.#lost) return true;
    this.#lost = true;
    this.#away = false;
    this.#wait = 1;
    if (this.#again) void this.#ask();
    else this.#schedule();
    return true;
  }

  /** The first request that fails for the second time although the server was there. */
  get #again(): string | undefined {
    return [...this.#failed].find((url) => this.#suspects.has(url));
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
        this.#away = true;
        this.#wait = Math.min(LONGEST, this.#wait * 1.6);
        this.#schedule();
        return;
      }
    }
    this.#lost = false;
    this.notices.banner(null);
    const again = this.#away ? undefined : this.#again;
    if (this.#away) this.#suspects.clear();
    else for (const url of this.#failed) this.#suspects.add(url);
    this.#failed.clear();
    if (again === undefined) return this.#goOn();
    this.notices.trouble(
      {
        title: 'An answer does not come through',
        advice: 'The server is there, but this request fails each time, maybe at something between it and this page.',
        detail: new URL(again).pathname,
      },
      { label: 'Try again', run: () => this.#goOn() },
    );
  }

  #goOn(): void {
    for (const listener of this.#back) listener();
  }
}
