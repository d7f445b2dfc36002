/**
 * Keeps loops and cells in step with the state: the line that is drawn, open or closed, and the cells
 * of the sources while these are shown. Beside the conductor, which asks for fields and paths.
 */
import { GeodesicError, type Ask } from 'geodesicd-client';
import { methodOf } from './costs.ts';
import { Newest } from './newest.ts';
import { regionsOf } from './painted.ts';
import { fieldKey, fieldQuestion, keyOf, sourcesOf, type Attempt, type FieldQuestion, type Questions } from './questions.ts';
import { surfaceOf, type Results } from './results.ts';
import { spotOf, spotText } from './spot_text.ts';
import { byCost, differ, isPlanar, mayHaveCells, UNPAINTED, type Drawn, type Line, type State, type Store } from './state.ts';

/** Rounds of Lloyd's algorithm at a press. */
const ROUNDS = 5;

interface DrawnQuestion {
  readonly state: State;
  readonly drawn: Drawn;
  readonly key: string;
}

/** What the sources' field depends on, and with it cells and discs. */
const OF_FIELD = ['sources', 'curves', 'walking', 'method', 'pointsPerEdge', 'painted'] as const;

/** What the drawn line depends on; null where there is none to ask for. */
export function drawnKey(state: State): string | null {
  const { loop } = state;
  if (!loop || (loop.kind === 'open' && loop.points.length < 2)) return null;
  // Loops are of lengths. A plane's section is no path: no method has a part in it.
  const painted = state.painted.as === 'weights' ? { ...state.painted, faces: [] } : state.painted;
  const by = { ...state, walking: null, painted, ...(isPlanar(loop) && { method: '', pointsPerEdge: null }) };
  return [keyOf(by), loop.kind, loop.normal ?? '', ...loop.points.map(spotText)].join('|');
}

export class Shapes {
  readonly #drawn = new Newest<DrawnQuestion>((asked, signal) => this.#askDrawn(asked, signal), ({ key }) => key);
  readonly #cells = new Newest<FieldQuestion>((asked, signal) => this.#askCells(asked, signal), fieldKey);
  readonly #disc = new Newest<FieldQuestion & { radius: number }>((asked, signal) => this.#askDisc(asked, signal), (asked) => `${fieldKey(asked)}|${asked.radius}`);
  readonly #lines = new Newest<State>((asked, signal) => this.#askLines(asked, signal));
  readonly #relaxing = new Newest<FieldQuestion>((asked, signal) => this.#askRelaxed(asked, signal));
  readonly #all = [this.#drawn, this.#lines, this.#disc, this.#cells, this.#relaxing] as const;

  constructor(
    private readonly questions: Questions,
    private readonly state: Store<State>,
    private readonly results: Store<Results>,
    private readonly attempt: Attempt,
  ) {}

  get busy(): boolean {
    return this.#all.some(({ busy }) => busy);
  }

  cancel(): void {
    for (const running of this.#all) running.cancel();
  }

  /** Asks for whatever the state wants and the results lack. */
  want(now: State): void {
    this.#wantDrawn(now);
    this.#wantCells(now);
    this.#wantLines(now);
    this.#wantDisc(now);
  }

  follow(now: State, before: State): void {
    if (drawnKey(now) !== drawnKey(before)) this.#wantDrawn(now);
    if (now.curves !== before.curves || now.painted.walls !== before.painted.walls) this.#wantLines(now);
    const fieldChanged = differ(now, before, ...OF_FIELD);
    if (fieldChanged || now.show !== before.show) this.#wantCells(now);
    if (fieldChanged || now.disc !== before.disc) this.#wantDisc(now);
    if (now.sources !== before.sources) this.#relaxing.cancel(); // the answer would be about others
  }

  /** Moves each source towards the middle of its cell. */
  relax(): void {
    const question = fieldQuestion(this.state.value);
    if (question && question.sources.length > 1) this.#relaxing.ask(question, true);
  }

  #ready(now: State): boolean {
    return surfaceOf(now, this.results.value) !== null && this.results.value.methods.length > 0;
  }

  #wantDrawn(now: State): void {
    const key = drawnKey(now);
    const { drawn } = this.results.value;
    if (!key || !now.loop) {
      this.#drawn.cancel();
      this.results.set({ drawn: null, noLoop: null });
    } else if (drawn?.key === key) this.#drawn.cancel();
    else if (this.#ready(now)) {
      this.results.set({ noLoop: null }); // that was of another line
      this.#drawn.ask({ state: now, drawn: now.loop, key });
    }
  }

  async #askDrawn({ state, drawn, key }: DrawnQuestion, signal: AbortSignal): Promise<void> {
    const stop = () => this.#drawn.cancel();
    const { mesh } = state;
    const method = isPlanar(drawn) ? 'auto' : state.method;
    const refused = (noLoop: string | null) => {
      if (drawnKey(this.state.value) === key) this.results.set({ drawn: null, noLoop });
    };
    await this.attempt(signal, 'loop', async () => {
      try {
        const asked = queryOf(state, drawn);
        if (asked.query === 'path') {
          const { points, length } = await this.questions.ask('Path', mesh!, method, asked, signal, stop);
          if (!signal.aborted) this.results.set({ drawn: { points, length, loop: null, key }, noLoop: null });
        } else {
          const loop = await this.questions.ask('Loop', mesh!, method, asked, signal, stop);
          if (!signal.aborted) this.results.set({ drawn: { points: loop.points, length: loop.length, loop, key }, noLoop: null });
        }
      } catch (error) {
        // That nothing holds a loop is an answer: it stands where the length would.
        if (!(error instanceof GeodesicError) || error.code !== 'no_loop') throw error;
        refused(error.detail);
      }
    }, () => refused(null));
  }

  #wantDisc(now: State): void {
    const question = fieldQuestion(now);
    const { disc } = this.results.value;
    if (!question || now.disc === null || byCost(now)) {
      this.#disc.cancel();
      this.results.set({ disc: null });
    } else if (disc?.radius === now.disc && disc.key === fieldKey(question)) this.#disc.cancel();
    else if (this.#ready(now)) this.#disc.ask({ ...question, radius: now.disc });
  }

  async #askDisc(asked: FieldQuestion & { radius: number }, signal: AbortSignal): Promise<void> {
    const { mesh, method, radius, painted } = asked;
    await this.attempt(signal, 'disc', async () => {
      const query = { query: 'measure' as const, from: sourcesOf(asked), radii: radius, ...methodOf(asked), ...regionsOf(painted) };
      const { discs } = await this.questions.ask('Disc', mesh, method, query, signal, () => this.#disc.cancel());
      const [disc] = discs;
      if (!signal.aborted && disc && this.state.value.disc !== null) {
        this.results.set({ disc: { radius, area: disc.area, outline: disc.perimeter + disc.boundary, key: fieldKey(asked) } });
      }
    }, () => this.results.set({ disc: null }));
  }

  #wantLines(now: State): void {
    const wanted = linesOf(now);
    const { lines } = this.results.value;
    if ([...lines.keys()].some((line) => !wanted.includes(line))) {
      this.results.set({ lines: new Map([...lines].filter(([line]) => wanted.includes(line))) });
    }
    if (wanted.every((line) => lines.has(line))) this.#lines.cancel();
    else if (this.#ready(now)) this.#lines.ask(now);
  }

  /** As the server lays them: shortest paths over the whole surface. */
  async #askLines(asked: State, signal: AbortSignal): Promise<void> {
    for (const line of linesOf(asked)) {
      if (signal.aborted) return;
      if (this.results.value.lines.has(line) || !linesOf(this.state.value).includes(line)) continue;
      await this.attempt(signal, 'lines', async () => {
        const query = queryOf({ ...asked, method: 'auto', painted: UNPAINTED }, { kind: line.closed ? 'through' : 'open', points: line.points, normal: null });
        const stop = () => this.#lines.cancel();
        const { points } = query.query === 'path'
          ? await this.questions.ask('Path', asked.mesh!, 'auto', query, signal, stop)
          : await this.questions.ask('Loop', asked.mesh!, 'auto', query, signal, stop);
        if (linesOf(this.state.value).includes(line)) this.results.set({ lines: new Map(this.results.value.lines).set(line, points) });
      });
    }
  }

  #wantCells(now: State): void {
    const question = fieldQuestion(now);
    const { cells } = this.results.value;
    if (!question || now.show !== 'cells' || !mayHaveCells(now)) {
      this.#cells.cancel();
      this.results.set({ cells: null });
    } else if (cells?.key === fieldKey(question)) this.#cells.cancel();
    else if (this.#ready(now)) this.#cells.ask(question);
  }

  async #askCells(asked: FieldQuestion, signal: AbortSignal): Promise<void> {
    await this.attempt(signal, 'cells', async () => {
      const answered = await this.questions.ask('Cells', asked.mesh, asked.method, cellsOf(asked, 0), signal, () => this.#cells.cancel());
      const present = fieldQuestion(this.state.value);
      const key = fieldKey(asked);
      if (!signal.aborted && present && fieldKey(present) === key) this.results.set({ cells: { answered, key } });
    }, () => this.results.set({ cells: null }));
  }

  async #askRelaxed(asked: FieldQuestion, signal: AbortSignal): Promise<void> {
    await this.attempt(signal, 'cells', async () => {
      const { cells } = await this.questions.ask('Relaxing', asked.mesh, asked.method, cellsOf(asked, ROUNDS), signal, () => this.#relaxing.cancel());
      if (signal.aborted || this.state.value.sources !== asked.sources) return;
      this.state.set({ sources: cells.map(({ site }, index) => (site.bary ? spotOf(site.face!, site.bary[0]!, site.bary[1]!) : asked.sources[index]!)) });
    });
  }
}

function linesOf({ curves, painted }: State): readonly Line[] {
  return [...curves, ...painted.walls];
}

/** What the drawn line is asked as; an open one as a path. */
export function queryOf(state: State, { kind, points, normal }: Drawn): Ask<'path'> | Ask<'loop'> {
  const on = regionsOf(state.painted);
  const rest = { ...methodOf(state), ...on };
  if (kind === 'open') {
    return { query: 'path', from: points[0]!, via: points.slice(1, -1), to: points.at(-1)!, refine: 'shortest', ...rest };
  }
  if (kind === 'through' || kind === 'around') return { query: 'loop', [kind]: points, ...rest };
  return { query: 'loop', at: points[0]!, normal: normal!, ...(kind === 'tape' && { hull: true }), ...on };
}

/** What cells are asked as; `relax`: rounds of Lloyd's algorithm before. */
export function cellsOf({ sources, curves: _curves, walking: _walking, painted, ...by }: FieldQuestion, relax: number): Ask<'voronoi'> {
  return { query: 'voronoi', from: sources, ...(relax && { relax }), ...methodOf(by), ...regionsOf(painted) };
}
