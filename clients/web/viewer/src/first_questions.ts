/**
 * What the page asks the server first: its methods and its meshes, each by itself. Without
 * the methods no question can be put, so they are asked for again until they are there.
 */
import type { Access } from './access.ts';
import type { Connection } from './connection.ts';
import type { Meshes } from './meshes.ts';
import { troubleOf } from './messages.ts';
import { SLOW, type Notices } from './notices.ts';
import type { Results } from './results.ts';
import { differ, POINTS, START, type State, type Store } from './state.ts';

export class FirstQuestions {
  #asking: Promise<void> | null = null;

  /** `again` is what whoever reads of a failure can do: all from the beginning. */
  constructor(
    private readonly access: Access,
    private readonly results: Store<Results>,
    private readonly meshes: Meshes,
    private readonly notices: Notices,
    private readonly connection: Connection,
    private readonly again: () => void,
  ) {}

  /** Both; whatever fails is told, and keeps the other from nothing. `then` is called as soon as the methods are there. */
  async ask(then: () => void): Promise<void> {
    await Promise.all([this.#methods().then(then), this.#offers(), this.#told(() => this.meshes.list())]);
  }

  /** What only some servers have; without an answer nothing of it is shown. */
  async #offers(): Promise<void> {
    const status = await this.access.client.status().catch(() => null);
    const limits: Readonly<Record<string, number>> = status?.limits ?? {};
    this.results.set({ offers: { walls: 'max_walls' in limits, curves: 'max_curve_points' in limits, costs: 'max_slopes' in limits } });
  }

  /** A change that needs an answer asks for the methods again, where they did not come. */
  follow(now: State, before: State, then: () => void): void {
    if (this.results.value.methods.length || this.connection.lost) return;
    if (differ(now, before, 'mesh', ...POINTS, 'measures')) void this.#methods().then(then);
  }

  /** One question at a time. */
  #methods(): Promise<void> {
    this.#asking ??= this.#told(async () => {
      const methods = await this.access.client.methods();
      const first = ({ name }: { name: string }) => Number(name !== START.method);
      this.results.set({ methods: [...methods].sort((a, b) => first(a) - first(b)) });
    }).finally(() => { this.#asking = null; });
    return this.#asking;
  }

  async #told(act: () => Promise<void>): Promise<void> {
    const progress = this.notices.begin('Waiting for the server', undefined, SLOW);
    try {
      await act();
    } catch (error) {
      if (this.connection.explains(error)) return;
      this.notices.trouble(troubleOf(error), this.access.remedy(error) ?? { label: 'Try again', run: this.again });
    } finally {
      progress.end();
    }
  }
}
