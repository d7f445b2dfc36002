/**
 * Keeps the results in step with the state: whatever changes there, the questions that it
 * touches are asked, and no others. A field is never asked for because a target moves.
 */
import type { Path } from 'geodesicd-client';
import type { Access } from './access.ts';
import type { Connection } from './connection.ts';
import { methodUsed } from './costs.ts';
import { troubleOf } from './messages.ts';
import { Newest } from './newest.ts';
import type { Notices } from './notices.ts';
import { Paths } from './paths.ts';
import { fieldKey, fieldQuestion, Questions, type Attempt, type FieldQuestion } from './questions.ts';
import { lookOf, type RegionLook } from './regions.ts';
import { errorAgainst, surfaceOf, UNANSWERED, type KnownField, type Results } from './results.ts';
import { Shapes } from './shapes.ts';
import { byCost, byRegion, differ, REGIONS, type Measure, type State, type Store } from './state.ts';

export class Conductor {
  readonly #questions: Questions;
  readonly #field = new Newest<FieldQuestion>((asked, signal) => this.#askField(asked, signal), fieldKey);
  readonly #exact = new Newest<FieldQuestion>((asked, signal) => this.#askExact(asked, signal));
  readonly #apart = new Newest<FieldQuestion>((asked, signal) => this.#askApart(asked, signal));
  readonly #trials = new Newest<State>((asked, signal) => this.#askTrials(asked, signal));
  readonly #paths: Paths;
  readonly #shapes: Shapes;

  constructor(
    private readonly access: Access,
    private readonly state: Store<State>,
    private readonly results: Store<Results>,
    private readonly notices: Notices,
    private readonly connection: Connection,
  ) {
    this.#questions = new Questions(() => access.client, results, notices);
    const attempt: Attempt = (...given) => this.#attempt(...given);
    this.#paths = new Paths(access, this.#questions, state, results, connection, attempt);
    this.#shapes = new Shapes(this.#questions, state, results, attempt);
    state.listen((now, before) => this.#follow(now, before));
    results.listen((now, before) => {
      if (now.field && now.field !== before.field) this.#paths.fieldHasCome();
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
    this.#paths.want(now);
    this.#shapes.want(now);
  }

  get busy(): boolean {
    return [this.#field, this.#exact, this.#apart, this.#trials, this.#paths, this.#shapes].some(({ busy }) => busy);
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
    for (const running of [this.#field, this.#exact, this.#apart, this.#trials, this.#paths, this.#shapes]) running.cancel();
  }

  /** Whether a point is being dragged. */
  hold(held: boolean): void {
    this.#paths.hold(held);
  }

  /** Takes a path that is there already into the list, so that it is not asked again. */
  keep(measure: Measure, path: Path): void {
    this.#paths.keep(measure, path);
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
      this.#paths.forget();
      this.results.set(UNANSWERED);
      return; // whoever loads the mesh sets the surface, and then all is asked
    }
    const byOther = differ(now, before, 'method', 'pointsPerEdge');
    const others = differ(now, before, 'sources', 'curves', 'painted', 'walking');
    if (others) {
      this.#trials.cancel();
      this.results.set({ trials: {}, stopped: false });
    }
    if (byOther || others || now.show !== before.show) this.#wantField(now, byOther || this.#questions.isLong(methodUsed(before)));
    this.#paths.follow(now, before);
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
    const divided = byRegion(now.show) && !now.curves.length && now.sources.length > 1 && now.sources.length <= REGIONS && !this.#questions.isLong(methodUsed(now));
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
    // Of ways that cost least there are no exact ones.
    return method && !byCost(question) ? { ...question, method } : null;
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
  #note({ method, ms, cost }: KnownField, error?: { mean: number; most: number }): void {
    if (cost !== null) return; // the list is about distances
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
