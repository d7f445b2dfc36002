/** Undo and redo of what a reader does to points, measures and the method; a drag is one step. Each mesh has its own. */
import { mayHaveCells, type State, type Store } from './state.ts';

/** A change of these is a step, and so is it to show cells or not; the tool and other colours follow along. */
const STEPS = ['sources', 'via', 'target', 'arrow', 'loop', 'painted', 'curves', 'disc', 'measures', 'method', 'pointsPerEdge', 'refine', 'walking'] as const;
const KEPT = [...STEPS, 'tool', 'show'] as const;
const MOST = 200;
/** Steps back have together at most so many ranges of painted faces: some tens of megabytes. */
const MOST_RANGES = 1_000_000;
/** What sliders change: in so many milliseconds it is one step. */
const SLID = ['arrow', 'disc', 'painted,weight'];
const TOGETHER = 600;

type Step = Pick<State, (typeof KEPT)[number]>;

export class History {
  #past: Step[] = [];
  #future: Step[] = [];
  /** Of the meshes that were left. */
  readonly #left = new Map<string, { past: Step[]; future: Step[] }>();
  #going = false;
  #held = false;
  #last = { at: 0, what: '' };
  readonly #listeners: (() => void)[] = [];

  constructor(private readonly state: Store<State>) {
    state.listen((now, before) => this.#note(now, before));
  }

  get canUndo(): boolean {
    return this.#past.length > 0;
  }

  get canRedo(): boolean {
    return this.#future.length > 0;
  }

  listen(listener: () => void): void {
    this.#listeners.push(listener);
  }

  /** While a point is held all that happens is one step. */
  hold(held: boolean): void {
    this.#held = held;
    this.#last.what = '';
  }

  /** What changes meanwhile is no step of the reader's. */
  quietly(change: () => void): void {
    this.#going = true;
    change();
    this.#going = false;
  }

  undo(): void {
    this.#go(this.#past, this.#future);
  }

  redo(): void {
    this.#go(this.#future, this.#past);
  }

  #note(now: State, before: State): void {
    if (this.#going) return;
    if (now.mesh !== before.mesh) {
      if (before.mesh) this.#left.set(before.mesh, { past: this.#past, future: this.#future });
      const { past, future } = (now.mesh && this.#left.get(now.mesh)) || { past: [], future: [] };
      this.#past = past;
      this.#future = future;
      this.#last.what = '';
      return this.#tell();
    }
    const weighted = now.painted.weight !== before.painted.weight;
    // Cells that vanish because too few sources are left are no step of their own.
    const cells = (now.show === 'cells') !== (before.show === 'cells') && mayHaveCells(now);
    const what = [...STEPS.filter((name) => now[name] !== before[name]), ...(cells ? ['cells'] : []), ...(weighted ? ['weight'] : [])].join();
    if (!what) return;
    const at = performance.now();
    const same = what === this.#last.what && (this.#held || (SLID.includes(what) && at - this.#last.at < TOGETHER));
    this.#last = { at, what };
    const last = this.#past.at(-1);
    if (same && this.#held && last && STEPS.every((name) => last[name] === now[name])) {
      // The drag was taken back: there was none.
      this.#past.pop();
      this.#last.what = '';
      return this.#tell();
    }
    if (same) return;
    this.#past.push(stepOf(before));
    this.#past.splice(0, tooOld(this.#past));
    this.#future = [];
    this.#tell();
  }

  #go(from: Step[], to: Step[]): void {
    const step = from.pop();
    if (!step) return;
    to.push(stepOf(this.state.value));
    this.quietly(() => this.state.set(step));
    this.#tell();
  }

  #tell(): void {
    for (const listener of this.#listeners) listener();
  }
}

/** How many of the oldest steps are to be forgotten; the last stays. */
function tooOld(past: readonly Step[]): number {
  let ranges = 0;
  for (let index = past.length - 1; index >= 0; index--) {
    const { painted } = past[index]!;
    if (painted !== past[index + 1]?.painted) ranges += painted.faces.length; // steps beside each other share theirs
    if (ranges > MOST_RANGES || past.length - index > MOST) return Math.min(index + 1, past.length - 1);
  }
  return 0;
}

function stepOf(state: State): Step {
  return Object.fromEntries(KEPT.map((name) => [name, state[name]])) as unknown as Step;
}
