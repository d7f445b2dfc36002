/**
 * Keeps paths in step with the state: that to the target, the straight one of the arrow, and those of the list.
 * Beside the conductor, which asks for fields.
 */
import type { Path } from 'geodesicd-client';
import type { Access } from './access.ts';
import type { Connection } from './connection.ts';
import { methodUsed } from './costs.ts';
import { Newest } from './newest.ts';
import { regionsOf } from './painted.ts';
import { askedKey, computing, fieldKey, fieldQuestion, pathKey, type Attempt, type PathQuestion, type Questions } from './questions.ts';
import { surfaceOf, type Results } from './results.ts';
import { differ, type Arrow, type Line, type Measure, type Painted, type Spot, type State, type Store } from './state.ts';

interface TraceQuestion {
  readonly mesh: string;
  readonly arrow: Arrow;
  readonly painted: Painted;
}

/** Milliseconds without a movement after which the path of a held point is at full strength again. */
const AT_REST = 300;

export class Paths {
  readonly #path = new Newest<PathQuestion>((asked, signal) => this.#askPath(asked, signal), askedKey);
  readonly #trace = new Newest<TraceQuestion>((asked, signal) => this.#askTrace(asked, signal));
  readonly #measures = new Newest<readonly Measure[]>((asked, signal) => this.#askMeasures(asked, signal));
  /** Of which state the path is that is shown. */
  #pathKey = '';
  /** Which question the path answers that is shown; none after a failure. */
  #answered = '';
  #held = false;
  #moved = 0;
  #strengthening = 0;
  /** Of measures of the present mesh, for as long as somebody may go back to them. */
  #kept = new WeakMap<Measure, Path>();

  constructor(
    private readonly access: Access,
    private readonly questions: Questions,
    private readonly state: Store<State>,
    private readonly results: Store<Results>,
    private readonly connection: Connection,
    private readonly attempt: Attempt,
  ) {}

  get busy(): boolean {
    return this.#path.busy || this.#trace.busy || this.#measures.busy;
  }

  cancel(): void {
    for (const running of [this.#path, this.#trace, this.#measures]) running.cancel();
  }

  /** Asks for whatever the state wants and the results lack. */
  want(now: State): void {
    this.#wantPath(now, false);
    this.#wantTrace(now);
    this.#wantMeasures(now);
  }

  follow(now: State, before: State): void {
    const byOther = differ(now, before, 'method', 'pointsPerEdge');
    const onOther = differ(now, before, 'painted', 'walking');
    if (byOther || onOther || differ(now, before, 'sources', 'curves', 'via', 'target', 'refine')) this.#wantPath(now, byOther);
    if (onOther || now.arrow !== before.arrow) this.#wantTrace(now);
    if (now.measures !== before.measures) this.#wantMeasures(now);
  }

  /** A path by a long method waits for its field; so does the choice among several sources. */
  fieldHasCome(): void {
    this.#wantPath(this.state.value, false);
  }

  /** Whether a point is being dragged. */
  hold(held: boolean): void {
    this.#held = held;
    this.#judge();
  }

  /** Takes a path that is there already into the list, so that it is not asked again. */
  keep(measure: Measure, path: Path): void {
    this.#kept.set(measure, path);
  }

  /** Another mesh is chosen. */
  forget(): void {
    this.#kept = new WeakMap();
  }

  #wantPath(now: State, interrupt: boolean): void {
    const { mesh, sources, curves, target, via, method, pointsPerEdge, refine, painted, walking } = now;
    const count = sources.length + curves.length;
    const { field, methods } = this.results.value;
    if (!methods.length) return;
    if (!mesh || !target || !count || !surfaceOf(now, this.results.value)) {
      this.#path.cancel();
      return this.results.set({ path: null, pathStart: null, stale: false, along: null, pathMs: null });
    }
    const present = field?.key === fieldKey(fieldQuestion(now)!);
    this.#moved = performance.now();
    this.#judge();
    if (!present && (count > 1 || this.questions.isLong(methodUsed(now)))) return; // asked once it has come
    const starts = this.#nearest(now, via[0] ?? target);
    const question: PathQuestion = { mesh, from: sources[0] ?? target, starts, via, to: target, method, pointsPerEdge, refine, painted, walking, key: pathKey(now) };
    if (this.results.value.path && this.#answered === askedKey(question)) this.#path.cancel();
    else this.#path.ask(question, interrupt);
  }

  /** The sources of which one is nearest to a spot: one, or those that meet in its face or are inside it. */
  #nearest({ sources, curves }: State, spot: Spot): readonly (Spot | Line)[] {
    const all = [...sources, ...curves];
    const { field, surface } = this.results.value;
    if (all.length === 1 || !field?.labels || !surface) return all.slice(0, 1);
    const labels = new Set(surface.cornersOf(spot.face).map((vertex) => field.labels![vertex]!));
    // A source inside the face need not be the nearest one of any of its corners.
    for (const [number, source] of sources.entries()) if (source.face === spot.face) labels.add(number);
    const starts = [...labels].map((label) => all[label]).filter((start) => start !== undefined);
    return starts.length ? starts : all.slice(0, 1);
  }

  async #askPath(asked: PathQuestion, signal: AbortSignal): Promise<void> {
    await this.attempt(signal, 'path', async () => {
      const { path, start } = await this.questions.path(asked, signal, () => this.#path.cancel());
      if (signal.aborted || !this.state.value.target) return;
      this.#pathKey = asked.key;
      this.#answered = askedKey(asked);
      const stale = this.results.value.stale || asked.key !== pathKey(this.state.value);
      this.results.set({ path, pathStart: start, stale, along: null, pathMs: computing(path.timing) });
      this.#judge();
    }, () => {
      this.#answered = ''; // so that it is told off when the same is wanted again and goes well
    });
  }

  /**
   * A path of other points than the present ones is faded at once and for as long as it is
   * shown, be it that none comes. What is dragged stays faded until it rests: it would flicker.
   */
  #judge(): void {
    clearTimeout(this.#strengthening);
    const { path, stale } = this.results.value;
    if (!path) return;
    if (this.#pathKey !== pathKey(this.state.value)) return this.results.set({ stale: true });
    if (!stale) return;
    const rest = this.#held ? this.#moved + AT_REST - performance.now() : 0;
    if (rest <= 0) this.results.set({ stale: false });
    else this.#strengthening = window.setTimeout(() => this.#judge(), rest);
  }

  #wantTrace(now: State): void {
    const { mesh, arrow, painted } = now;
    if (mesh && arrow && surfaceOf(now, this.results.value)) this.#trace.ask({ mesh, arrow, painted });
    else {
      this.#trace.cancel();
      this.results.set({ trace: null });
    }
  }

  async #askTrace({ mesh, arrow, painted }: TraceQuestion, signal: AbortSignal): Promise<void> {
    await this.attempt(signal, 'trace', async () => {
      const { from, direction, length } = arrow;
      const trace = await this.access.client.trace(mesh, { from, direction, length, ...regionsOf(painted) }, { signal });
      if (this.state.value.arrow && !signal.aborted) this.results.set({ trace });
    }, () => this.results.set({ trace: null }));
  }

  #wantMeasures(now: State): void {
    const { measures } = now;
    const measured = measures.map((measure) => this.#kept.get(measure) ?? null);
    this.results.set({ measured });
    if (surfaceOf(now, this.results.value) && this.results.value.methods.length && measured.includes(null)) this.#measures.ask(measures);
    else this.#measures.cancel();
  }

  async #askMeasures(asked: readonly Measure[], signal: AbortSignal): Promise<void> {
    const { mesh } = this.state.value;
    if (!mesh) return;
    for (const [index, measure] of asked.entries()) {
      if (this.#kept.has(measure)) continue;
      if (signal.aborted || this.connection.lost) return;
      // One that fails is told, and keeps none of those after it back.
      await this.attempt(signal, `measure ${index}`, async () => {
        const question = { ...measure, mesh, walking: null, starts: [measure.from], key: '' };
        const { path } = await this.questions.path(question, signal, () => this.#measures.cancel());
        this.#kept.set(measure, path);
        const { measures } = this.state.value;
        this.results.set({ measured: measures.map((each) => this.#kept.get(each) ?? null) });
      });
    }
  }
}
