/** What stood on each mesh when another was chosen, for as long as the page is open. */
import { WITHOUT_POINTS, type State } from './state.ts';

const NAMES = Object.keys(WITHOUT_POINTS) as (keyof typeof WITHOUT_POINTS)[];

type Points = Pick<State, keyof typeof WITHOUT_POINTS>;

export class Remembered {
  readonly #kept = new Map<string, Points>();

  /** Keeps points and measures of the state's mesh. */
  keep(state: State): void {
    if (state.mesh) this.#kept.set(state.mesh, Object.fromEntries(NAMES.map((name) => [name, state[name]])) as unknown as Points);
  }

  /** What was kept of a mesh; nothing for one that is new here. */
  of(mesh: string): Points {
    return this.#kept.get(mesh) ?? WITHOUT_POINTS;
  }
}
