/**
 * The questions that the page puts to the server, each with the fewest bytes: fields as
 * binary and kept here for going back and forth, exact methods as jobs with progress, and
 * paths from whichever source is nearest.
 */
import { GeodesicError, type GeodesicClient, type Method, type Path, type Timing } from 'geodesicd-client';
import { spotText } from './link.ts';
import { SLOW, type Notices } from './notices.ts';
import type { KnownField, Results } from './results.ts';
import type { Measure, Spot, State, Store } from './state.ts';

export interface FieldQuestion {
  readonly mesh: string;
  readonly sources: readonly Spot[];
  readonly method: string;
  readonly pointsPerEdge: number | null;
}

export interface PathQuestion extends Measure {
  readonly mesh: string;
  /** Where it may begin; the shortest path counts. */
  readonly starts: readonly Spot[];
  /** Of the state that asks, as `pathKey` gives it. */
  readonly key: string;
}

/** Meshes above this many vertices take long by any method. */
const LARGE = 400_000;
/** Bytes of fields that the page keeps. */
const KEEP = 96e6;

export function fieldKey({ mesh, sources, method, pointsPerEdge }: FieldQuestion): string {
  return [mesh, method, method === 'steiner' ? pointsPerEdge : '', ...sources.map(spotText)].join('|');
}

/** What a path depends on: two states of one key have the same path. */
export function pathKey({ mesh, sources, via, target, method, pointsPerEdge, refine }: State): string {
  const spots = [sources, via, target ? [target] : []].map((some) => some.map(spotText).join(';'));
  return [mesh, method, method === 'steiner' ? pointsPerEdge : '', refine, ...spots].join('|');
}

/** The state's own field. */
export function fieldQuestion(state: State): FieldQuestion | null {
  const { mesh, sources, method, pointsPerEdge } = state;
  return mesh && sources.length ? { mesh, sources, method, pointsPerEdge } : null;
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
    const { mesh, sources, method } = question;
    const query = { from: sources, labels: sources.length > 1, ...methodOf(question) };
    const field = this.isLong(method)
      ? await this.#asJob(`Distances by ${nameOf(method)}`, stop, (onProgress) =>
          this.client().job(mesh, { query: 'distance', ...query }, { signal, onProgress }),
        )
      : await this.#plainly('Distances', stop, () => this.client().distance(mesh, query, { signal }));
    const made: KnownField = {
      values: field.values,
      labels: field.labels ?? null,
      sources: sources.length,
      max: field.max ?? 0,
      ms: computing(field.timing),
      method,
      key,
    };
    this.#keep(made);
    return made;
  }

  /** The shortest of the paths from the starts, through `via`. */
  async path(question: PathQuestion, signal: AbortSignal, stop: () => void): Promise<Path> {
    const { mesh, starts, via, to, refine, method } = question;
    const ask = (from: Spot) => {
      const query = { from, via, to, refine: refine ? ('shortest' as const) : ('none' as const), ...methodOf(question) };
      // From one source the field is there already; between via points are others.
      if (!this.isLong(method) || (starts.length === 1 && !via.length)) {
        return this.#plainly('Path', stop, () => this.client().path(mesh, query, { signal }));
      }
      return this.#asJob(`Path by ${nameOf(method)}`, stop, (onProgress) =>
        this.client().job(mesh, { query: 'path', ...query }, { signal, onProgress }),
      );
    };
    let best: Path | null = null;
    for (const start of starts) {
      const path = await ask(start);
      if (!best || (path.length ?? Infinity) < (best.length ?? Infinity)) best = path;
    }
    return best!;
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
    let bytes = 0;
    for (const { values } of this.#kept.values()) bytes += values.byteLength;
    for (const [key, { values }] of this.#kept) {
      if (bytes <= KEEP || key === field.key) break;
      this.#kept.delete(key);
      bytes -= values.byteLength;
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

/** The parameters of the method; only steiner has one. */
export function methodOf({ method, pointsPerEdge }: { method: string; pointsPerEdge: number | null }) {
  const steiner = method === 'steiner' && pointsPerEdge !== null;
  return { method: method as Method, ...(steiner ? { points_per_edge: pointsPerEdge } : {}) };
}

/** What the server spent on the question itself; null where it only looked the answer up. */
export function computing({ solve, trace }: Timing): number | null {
  return solve === undefined && trace === undefined ? null : (solve ?? 0) + (trace ?? 0);
}
