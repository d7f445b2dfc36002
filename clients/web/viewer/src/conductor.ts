/**
 * Keeps the results in step with the state: whatever changes there, the questions that it
 * touches are asked, and no others. A field is never asked for because a target moves.
 */
import type { Path } from 'geodesicd-client';
import type { Access } from './access.ts';
import type { Connection } from './connection.ts';
import { troubleOf } from './messages.ts';
import { Newest } from './newest.ts';
import type { Notices } from './notices.ts';
import { regionsOf } from './painted.ts';
import {
  computing, fieldKey, fieldQuestion, pathKey, Questions, type FieldQuestion, type PathQuestion,
} from './questions.ts';
import { lookOf, type RegionLook } from './regions.ts';
import { errorAgainst, surfaceOf, type KnownField, type Results } from './results.ts';
import { Shapes } from './shapes.ts';
import { byRegion, REGIONS, type Arrow, type Line, type Measure, type Painted, type Spot, type State, type Store } from './state.ts';

interface TraceQuestion {
  readonly mesh: string;
  readonly arrow: Arrow;
  readonly painted: Painted;
}

/** Milliseconds without a movement after which the path of a held point is at full strength again. */
const AT_REST = 300;

export class Conductor {
  readonly #questions: Questions;
  readonly #field = new Newest<FieldQuestion>((asked, signal) => this.#askField(asked, signal), fieldKey);
  readonly #exact = new Newest<FieldQuestion>((asked, signal) => this.#askExact(asked, signal));
  readonly #apart = new Newest<FieldQuestion>((asked, signal) => this.#askApart(asked, signal));
  readonly #path = new Newest<PathQuestion>((asked, signal) => this.#askPath(asked, signal));
  readonly #trace = new Newest<TraceQuestion>((asked, signal) => this.#askTrace(asked, signal));
  readonly #measures = new Newest<readonly Measure[]>((asked, signal) => this.#askMeasures(asked, signal));
  readonly #trials = new Newest<State>((asked, signal) => this.#askTrials(asked, signal));
  readonly #shapes: Shapes;
  /** Of which state the path is that is shown. */
  #pathKey = '';
  #held = false;
  #moved = 0;
  #strengthening = 0;
  readonly #paths = new Map<Measure, Path>();

  constructor(
    private readonly access: Access,
    private readonly state: Store<State>,
    private readonly results: Store<Results>,
    private readonly notices: Notices,
    private readonly connection: Connection,
  ) {
    this.#questions = new Questions(() => access.client, results, notices);
    this.#shapes = new Shapes(this.#questions, state, results, (...given) => this.#attempt(...given));
    state.listen((now, before) => this.#follow(now, before));
    results.listen((now, before) => {
      // A path by a long method waits for its field; so does the choice among several sources.
      if (now.field && now.field !== before.field) this.#wantPath(this.state.value, false);
      if (now.surface !== before.surface && now.surface) this.askAgain();
    });
    connection.onBack(() => {
      this.#questions.abandon(); // what the network took with it
      this.askAgain();
    });
  }

  /** Asks for whatever the state wants and the results lack. */
  askAgain(): void {
    const now = this.state.value;
    this.#wantField(now, false);
    this.#wantPath(now, false);
    this.#wantTrace(now);
    this.#wantMeasures(now);
    this.#shapes.want(now);
  }

  get busy(): boolean {
    return this.#shapes.busy || [this.#field, this.#exact, this.#apart, this.#path, this.#trace, this.#measures, this.#trials].some(({ busy }) => busy);
  }

  /** Stops everything that is under way, as its reader wishes. */
  stop(): void {
    if (this.#trials.busy) this.results.set({ stopped: true });
    this.cancel();
    this.#backToShown();
  }

  /** What is chosen is what is seen: after a cancelled field the method of the one that stays, if its points are the present ones. */
  #backToShown(): void {
    const { field } = this.results.value;
    if (field && field.method !== this.state.value.method) this.state.set({ method: field.method });
    else this.#dropField();
  }

  /** Whoever asked is gone, or cannot hear: the server need not go on. */
  abandon(): void {
    this.#questions.abandon();
    this.cancel();
  }

  /** Without a change of the state. */
  cancel(): void {
    for (const running of [this.#field, this.#exact, this.#apart, this.#path, this.#trace, this.#measures, this.#trials]) running.cancel();
    this.#shapes.cancel();
  }

  /** Whether a point is being dragged. */
  hold(held: boolean): void {
    this.#held = held;
    this.#judge();
  }

  /** Moves the sources towards the middles of their cells. */
  relax(): void {
    this.#shapes.relax();
  }

  /** Tries every method on the present sources, for the list of methods. */
  compare(): void {
    this.#trials.ask(this.state.value, true);
  }

  #follow(now: State, before: State): void {
    if (now.mesh !== before.mesh) {
      this.cancel();
      this.#paths.clear();
      this.results.set({ field: null, error: null, apart: null, regions: null, trials: {}, stopped: false, path: null, stale: false, pathMs: null, trace: null, lines: new Map(), drawn: null, noLoop: null, disc: null, cells: null, measured: [] });
      return; // whoever loads the mesh sets the surface, and then all is asked
    }
    const byOther = now.method !== before.method || now.pointsPerEdge !== before.pointsPerEdge;
    const fromOther = now.sources !== before.sources || now.curves !== before.curves;
    const onOther = now.painted !== before.painted || now.walking !== before.walking;
    if (fromOther || onOther) {
      this.#trials.cancel();
      this.results.set({ trials: {}, stopped: false });
    }
    if (byOther || fromOther || onOther || now.show !== before.show) this.#wantField(now, byOther || this.#questions.isLong(before.method));
    if (byOther || fromOther || onOther || now.via !== before.via || now.target !== before.target || now.refine !== before.refine) {
      this.#wantPath(now, byOther);
    }
    if (onOther || now.arrow !== before.arrow) this.#wantTrace(now);
    if (now.measures !== before.measures) this.#wantMeasures(now);
    this.#shapes.follow(now, before);
  }

  #wantField(now: State, interrupt: boolean): void {
    const question = fieldQuestion(now);
    if (!this.results.value.methods.length) return; // asked once it is known which are long
    if (!question || !surfaceOf(now, this.results.value)) {
      this.#field.cancel();
      this.#exact.cancel();
      return this.results.set({ field: null, error: null, regions: null });
    }
    if (this.results.value.field?.key !== fieldKey(question)) {
      const kept = this.#questions.kept(question);
      if (kept) {
        this.#field.cancel();
        this.#show(kept);
      } else this.#field.ask(question, interrupt);
    } else this.#field.cancel(); // what is on its way is not wanted any more: the points went back
    const divided = byRegion(now.show) && !now.curves.length && now.sources.length > 1 && now.sources.length <= REGIONS && !this.#questions.isLong(now.method);
    if (!divided) this.#apart.cancel();
    else if (this.results.value.apart?.key !== fieldKey(question)) this.#apart.ask(question);
    const { field, regions } = this.results.value;
    if (field && !regions) this.results.set({ regions: this.#looks(field) });
    const exact = this.#exactOf(question);
    if (now.show !== 'error') this.#exact.cancel();
    else if (exact) this.#exact.ask(exact, interrupt);
  }

  /** Only where they are shown: it takes a look at every face. */
  #looks({ labels, sources }: KnownField): RegionLook | null {
    const { surface } = this.results.value;
    return labels && surface && byRegion(this.state.value.show) ? lookOf(labels, surface.triangles, sources) : null;
  }

  /** The same question for the exact method. */
  #exactOf(question: FieldQuestion): FieldQuestion | null {
    const method = this.results.value.methods.find(({ exact }) => exact)?.name;
    // Of ways on foot there are no exact ones.
    return method && !question.walking ? { ...question, method } : null;
  }

  async #askField(asked: FieldQuestion, signal: AbortSignal): Promise<void> {
    await this.#attempt(signal, 'field', async () => {
      const stop = () => {
        this.#field.cancel();
        this.#backToShown();
      };
      const field = await this.#questions.field(asked, signal, stop);
      if (!signal.aborted) this.#show(field);
    }, () => this.#dropField());
  }

  /** Takes away a field of other points or another method than the present ones, as theirs does not come. */
  #dropField(): void {
    const question = fieldQuestion(this.state.value);
    if (question && this.results.value.field?.key === fieldKey(question)) return;
    this.results.set({ field: null, error: null, apart: null, regions: null });
  }

  #show(field: KnownField): void {
    // The fields of its sources may have come before it.
    const apart = this.results.value.apart?.key === field.key ? this.results.value.apart : null;
    this.results.set({ field, error: null, regions: this.#looks(field), apart });
    this.#note(field);
    this.#noteError(field);
  }

  /** Each source's field by itself; until they are here, regions have the labels' coarser borders. */
  async #askApart(asked: FieldQuestion, signal: AbortSignal): Promise<void> {
    await this.#attempt(signal, 'apart', async () => {
      const fields: KnownField[] = [];
      for (const source of asked.sources) {
        const own = { ...asked, sources: [source], curves: [] };
        fields.push(await this.#questions.field(own, signal, () => this.#apart.cancel()));
      }
      const present = fieldQuestion(this.state.value);
      const key = fieldKey(asked);
      if (present && fieldKey(present) === key) this.results.set({ apart: { key, fields } });
    });
  }

  async #askExact(asked: FieldQuestion, signal: AbortSignal): Promise<void> {
    await this.#attempt(signal, 'exact', async () => {
      const exact = await this.#questions.field(asked, signal, () => {
        this.#exact.cancel();
        this.state.set({ show: 'distance' });
      });
      this.#note(exact);
      const { field } = this.results.value;
      if (field) this.#noteError(field);
    });
  }

  /** Puts the error on show, if the exact field of the same sources is here. */
  #noteError(field: KnownField): void {
    const question = fieldQuestion(this.state.value);
    const exactly = question && this.#exactOf(question);
    const exact = exactly && this.#questions.kept(exactly);
    if (!exact || fieldKey(question) !== field.key) return;
    const error = errorAgainst(field.values, exact.values);
    this.results.set({ error });
    this.#note(field, error);
  }

  /** What a field tells of its method, into the list of methods. */
  #note({ method, ms }: KnownField, error?: { mean: number; most: number }): void {
    if (this.state.value.walking) return;
    const before = this.results.value.trials[method];
    const trial = {
      ms: ms ?? before?.ms ?? null,
      mean: error?.mean ?? before?.mean ?? null,
      most: error?.most ?? before?.most ?? null,
    };
    this.results.set({ trials: { ...this.results.value.trials, [method]: trial } });
  }

  async #askTrials(asked: State, signal: AbortSignal): Promise<void> {
    const question = fieldQuestion(asked);
    const exactly = question && this.#exactOf(question);
    if (!question || !exactly) return;
    const { methods } = this.results.value;
    const stop = () => {
      this.#trials.cancel();
      this.results.set({ stopped: true });
    };
    this.results.set({ stopped: false });
    const progress = this.notices.begin('Comparing all methods', stop);
    await this.#attempt(signal, 'trials', async () => {
      const exact = await this.#questions.field(exactly, signal, stop);
      for (const [index, { name }] of methods.entries()) {
        progress.say('Comparing all methods', index / methods.length);
        const field = await this.#questions.field({ ...question, method: name }, signal, stop);
        this.#note(field, errorAgainst(field.values, exact.values));
      }
    });
    progress.end();
  }

  #wantPath(now: State, interrupt: boolean): void {
    const { mesh, sources, curves, target, via, method, pointsPerEdge, refine, painted, walking } = now;
    const count = sources.length + curves.length;
    const { field, methods } = this.results.value;
    if (!methods.length) return;
    if (!mesh || !target || !count || !surfaceOf(now, this.results.value)) {
      this.#path.cancel();
      return this.results.set({ path: null, stale: false, along: null, pathMs: null });
    }
    const present = field?.key === fieldKey(fieldQuestion(now)!);
    this.#moved = performance.now();
    this.#judge();
    if (!present && (count > 1 || this.#questions.isLong(method))) return; // asked once it has come
    const starts = this.#nearest(now, via[0] ?? target);
    this.#path.ask({ mesh, from: sources[0] ?? target, starts, via, to: target, method, pointsPerEdge, refine, painted, walking, key: pathKey(now) }, interrupt);
  }

  /** The sources of which one is nearest to a spot: one, or those that meet in its face. */
  #nearest({ sources, curves }: State, spot: Spot): readonly (Spot | Line)[] {
    const all = [...sources, ...curves];
    const { field, surface } = this.results.value;
    if (all.length === 1 || !field?.labels || !surface) return all.slice(0, 1);
    const labels = new Set(surface.cornersOf(spot.face).map((vertex) => field.labels![vertex]!));
    const starts = [...labels].map((label) => all[label]).filter((start) => start !== undefined);
    return starts.length ? starts : all.slice(0, 1);
  }

  async #askPath(asked: PathQuestion, signal: AbortSignal): Promise<void> {
    await this.#attempt(signal, 'path', async () => {
      const path = await this.#questions.path(asked, signal, () => this.#path.cancel());
      if (signal.aborted || !this.state.value.target) return;
      this.#pathKey = asked.key;
      const stale = this.results.value.stale || asked.key !== pathKey(this.state.value);
      this.results.set({ path, stale, along: null, pathMs: computing(path.timing) });
      this.#judge();
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
    await this.#attempt(signal, 'trace', async () => {
      const { from, direction, length } = arrow;
      const trace = await this.access.client.trace(mesh, { from, direction, length, ...regionsOf(painted) }, { signal });
      if (this.state.value.arrow && !signal.aborted) this.results.set({ trace });
    }, () => this.results.set({ trace: null }));
  }

  #wantMeasures(now: State): void {
    const { measures } = now;
    const measured = measures.map((measure) => this.#paths.get(measure) ?? null);
    this.results.set({ measured });
    if (surfaceOf(now, this.results.value) && this.results.value.methods.length && measured.includes(null)) this.#measures.ask(measures);
  }

  /** Takes a path that is there already into the list, so that it is not asked again. */
  keep(measure: Measure, path: Path): void {
    this.#paths.set(measure, path);
  }

  async #askMeasures(asked: readonly Measure[], signal: AbortSignal): Promise<void> {
    const { mesh } = this.state.value;
    if (!mesh) return;
    for (const [index, measure] of asked.entries()) {
      if (this.#paths.has(measure)) continue;
      if (signal.aborted || this.connection.lost) return;
      // One that fails is told, and keeps none of those after it back.
      await this.#attempt(signal, `measure ${index}`, async () => {
        const question = { ...measure, mesh, walking: null, starts: [measure.from], key: '' };
        this.#paths.set(measure, await this.#questions.path(question, signal, () => this.#measures.cancel()));
        const { measures } = this.state.value;
        this.results.set({ measured: measures.map((each) => this.#paths.get(each) ?? null) });
      });
    }
  }

  /**
   * Errors are told, until the same goes well, and `failed` is called; an abort is somebody's wish;
   * a lost server is the connection's matter.
   */
  async #attempt(signal: AbortSignal, about: string, run: () => Promise<void>, failed?: () => void): Promise<void> {
    try {
      await run();
      this.notices.settle(about);
    } catch (error) {
      if (signal.aborted || this.connection.explains(error)) return;
      this.notices.trouble({ ...troubleOf(error), about }, this.access.remedy(error));
      failed?.();
    }
  }
}
