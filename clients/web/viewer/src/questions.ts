/**
 * The questions that the page puts to the server, each with the fewest bytes: fields as
 * binary and kept here for going back and forth, exact methods as jobs with progress, and
 * paths from whichever source is nearest.
 */
import {
  GeodesicError, type Ask, type GeodesicClient, type Path, type Queries, type Timing,
} from 'geodesicd-client';
import { costKind, methodAndCosts, methodUsed, walkingText } from './costs.ts';
import { SLOW, type Notices } from './notices.ts';
import { paintedKey, regionsOf } from './painted.ts';
import type { KnownField, Results } from './results.ts';
import { curveText, lineText, spotText } from './spot_text.ts';
import { byCost, type Line, type Measure, type Painted, type Spot, type State, type Store, type Walking } from './state.ts';

export interface FieldQuestion {
  readonly mesh: string;
  readonly sources: readonly Spot[];
  readonly curves: readonly Line[];
  readonly method: string;
  readonly pointsPerEdge: number | null;
  readonly painted: Painted;
  readonly walking: Walking | null;
}

export interface PathQuestion extends Measure {
  readonly mesh: string;
  readonly walking: Walking | null;
  /** Where it may begin; the path of least length or cost counts. */
  readonly starts: readonly (Spot | Line)[];
  /** Of the state that asks, as `pathKey` gives it. */
  readonly key: string;
}

/** Runs what may fail, and tells; `about` is what settles it. */
export type Attempt = (signal: AbortSignal, about: string, run: () => Promise<void>, failed?: () => void) => Promise<void>;

/** Meshes above this many vertices take long by any method. */
const LARGE = 400_000;
/** Bytes of fields that the page keeps. */
const KEEP = 96e6;

/** Of what every answer depends on but for its points. */
export function keyOf({ mesh, method, pointsPerEdge, painted, walking }: Omit<FieldQuestion, 'sources' | 'curves' | 'mesh'> & { mesh: string | null }): string {
  const used = methodUsed({ method, walking, painted });
  return [mesh, paintedKey(painted), walkingText(walking), used, used === 'steiner' ? pointsPerEdge : ''].join('|');
}

export function fieldKey(question: FieldQuestion): string {
  return [keyOf(question), ...question.sources.map(spotText), ...question.curves.map(lineText)].join('|');
}

/** What a path depends on: two states of one key have the same path. */
export function pathKey(state: State): string {
  const { sources, curves, via, target, refine } = state;
  const spots = [sources, via, target ? [target] : []].map((some) => some.map(spotText).join(';'));
  return [keyOf(state), refine && !byCost(state), ...spots, ...curves.map(lineText)].join('|');
}

/** What a path is that was asked for: of several sources, that from those that are nearest. */
export function askedKey({ key, starts }: PathQuestion): string {
  return [key, ...starts.map((start) => ('points' in start ? lineText(start) : spotText(start)))].join('|');
}

/** As the API takes it. */
export function sourceOf(start: Spot | Line): Spot | string {
  return 'points' in start ? curveText(start) : start;
}

/** As the API takes them. */
export function sourcesOf({ sources, curves }: Pick<State, 'sources' | 'curves'>): (Spot | string)[] {
  return [...sources, ...curves].map(sourceOf);
}

/** The state's own field. */
export function fieldQuestion(state: State): FieldQuestion | null {
  const { mesh, sources, curves, method, pointsPerEdge, painted, walking } = state;
  return mesh && sources.length + curves.length ? { mesh, sources, curves, method, pointsPerEdge, painted, walking } : null;
}

export class Questions {
  /** Jobs that the server has for this page, until they have ended or are known to be cancelled. */
  readonly #jobs = new Set<string>();
  readonly #kept = new Map<string, KnownField>();

  constructor(
    private readonly client: () => GeodesicClient,
    private readonly results: Store<Results>,
    private readonly notices: Notices,
  ) {}

  /** Whether a field by this method is worth a job with its progress. */
  isLong(method: string): boolean {
    const vertices = this.results.value.surface?.about.vertices ?? 0;
    const exact = this.results.value.methods.find(({ name }) => name === method)?.exact;
    return vertices > LARGE || (exact ?? false);
  }

  kept(question: FieldQuestion): KnownField | undefined {
    return this.#kept.get(fieldKey(question));
  }

  /** The distances from the nearest of the sources. Rejects as the client does. */
  async field(question: FieldQuestion, signal: AbortSignal, stop: () => void): Promise<KnownField> {
    const key = fieldKey(question);
    const known = this.#kept.get(key);
    if (known) {
      this.#kept.delete(key);
      this.#kept.set(key, known); // the last used go last
      return known;
    }
    const { mesh, sources, curves, method } = question;
    const count = sources.length + curves.length;
    const query = { from: sourcesOf(question), labels: count > 1, ...methodAndCosts(question), ...regionsOf(question.painted) };
    const field = this.isLong(methodUsed(question))
      ? await this.#asJob(`Distances by ${nameOf(methodUsed(question))}`, stop, (onProgress) =>
          this.client().job(mesh, { query: 'distance', ...query }, { signal, onProgress }),
        )
      : await this.#plainly('Distances', stop, () => this.client().distance(mesh, query, { signal }));
    const made: KnownField = {
      values: field.values,
      labels: field.labels ?? null,
      sources: count,
      max: field.max ?? 0,
      ms: computing(field.timing),
      method,
      cost: costKind(question),
      warnings: field.warnings,
      key,
    };
    this.#keep(made);
    return made;
  }

  /** The shortest of the paths from the starts, or that of least cost, through `via`; and which of them it begins at. */
  async path(question: PathQuestion, signal: AbortSignal, stop: () => void): Promise<{ path: Path; start: Spot | Line }> {
    const { mesh, starts, via, to } = question;
    const method = methodUsed(question);
    const refine = question.refine && !costKind(question);
    const ask = (start: Spot | Line) => {
      const query = { from: sourceOf(start), via, to, refine: refine ? ('shortest' as const) : ('none' as const), ...methodAndCosts(question), ...regionsOf(question.painted) };
      // From one source the field is there already; between via points are others.
      if (!this.isLong(method) || (starts.length === 1 && !via.length)) {
        return this.#plainly('Path', stop, () => this.client().path(mesh, query, { signal }));
      }
      return this.#asJob(`Path by ${nameOf(method)}`, stop, (onProgress) =>
        this.client().job(mesh, { query: 'path', ...query }, { signal, onProgress }),
      );
    };
    let best: { path: Path; start: Spot | Line } | null = null;
    const least = ({ cost, length }: Path) => cost ?? length ?? Infinity;
    for (const start of starts) {
      const path = await ask(start);
      if (!best || least(path) < least(best.path)) best = { path, start };
    }
    return best!;
  }

  /** Any other query, as a job where the method takes long. `by`: its method. */
  async ask<Name extends 'path' | 'loop' | 'voronoi' | 'measure'>(
    what: string, mesh: string, by: string, query: Ask<Name>, signal: AbortSignal, stop: () => void,
  ): Promise<Queries[Name]['gives']> {
    if (this.isLong(by)) {
      return this.#asJob(`${what} by ${nameOf(by)}`, stop, (onProgress) => this.client().job<Name>(mesh, query, { signal, onProgress }));
    }
    const { query: name, ...asked } = query;
    const client = this.client();
    const run = client[name].bind(client) as (mesh: string, asked: object, options: object) => Promise<Queries[Name]['gives']>;
    return this.#plainly(what, stop, () => run(mesh, asked, { signal }));
  }

  /** What is answered at once by most servers, and may be by one that says nothing for long. */
  async #plainly<T>(what: string, stop: () => void, run: () => Promise<T>): Promise<T> {
    const progress = this.notices.begin(`${what}: waiting for the server`, stop, SLOW);
    try {
      return await run();
    } finally {
      progress.end();
    }
  }

  async #asJob<T>(
    what: string,
    stop: () => void,
    run: (onProgress: (job: { id: string; state: string; progress: number }) => void) => Promise<T>,
  ): Promise<T> {
    const progress = this.notices.begin(what, stop);
    try {
      return await run((job) => {
        if (['queued', 'running'].includes(job.state)) this.#jobs.add(job.id);
        else this.#jobs.delete(job.id);
        if (job.state === 'queued') progress.say(`${what}: waiting for its turn`);
        else progress.say(what, job.progress);
      });
    } finally {
      progress.end();
    }
  }

  /**
   * Cancels all jobs, be it the last that the page does: the requests go out although it is
   * closed. What could not be sent is sent with the next call.
   */
  abandon(): void {
    for (const id of this.#jobs) {
      const forgotten = () => this.#jobs.delete(id);
      this.client()
        .request({ method: 'DELETE', path: `/v1/jobs/${id}`, keepalive: true, retry: false })
        .then(forgotten, (error: unknown) => { if (error instanceof GeodesicError) forgotten(); });
    }
  }

  #keep(field: KnownField): void {
    this.#kept.set(field.key, field);
    const bytesOf = ({ values, labels }: KnownField) => values.byteLength + (labels?.byteLength ?? 0);
    let bytes = 0;
    for (const each of this.#kept.values()) bytes += bytesOf(each);
    for (const [key, each] of this.#kept) {
      if (bytes <= KEEP || key === field.key) break;
      this.#kept.delete(key);
      bytes -= bytesOf(each);
    }
  }
}

/** Methods that bear people's names; a new one is said as the server spells it. */
const NAMES: Readonly<Record<string, string>> = { chen_han: 'Chen–Han' };

/** `fast_marching` as it is said. */
export function nameOf(method: string): string {
  // A link may say any name, be it that of a property that every object has.
  const name = (Object.hasOwn(NAMES, method) && NAMES[method]) || method.replaceAll('_', ' ');
  return name.charAt(0).toUpperCase() + name.slice(1);
}

/** What the server spent on the question itself; null where it only looked the answer up. */
export function computing({ solve, trace }: Timing): number | null {
  return solve === undefined && trace === undefined ? null : (solve ?? 0) + (trace ?? 0);
}
