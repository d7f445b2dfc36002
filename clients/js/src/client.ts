/** The client: a method for each operation of the API. */
import { exchangeGeometry, type ArrivingGeometry } from './arriving.js';
import { batch, type BatchAnswer, type BatchQuery } from './batch.js';
import type { MeshMetadata, MethodInfo, QueryName, Schemas, Status } from './contract.js';
import { exchangeAsJob, type JobOptions } from './jobs.js';
import { fieldPlan, meshPath, planOf, queryCall, shownCall, type Plan } from './plans.js';
import type * as queries from './queries.js';
import type { CallOptions, Precision, QueryOptions } from './queries.js';
import * as replies from './replies.js';
import { sparseTable, tableRows } from './table_rows.js';
import { table } from './tables.js';
import { Transport, type Call, type Reply } from './transport.js';
import * as uploads from './upload.js';

export interface ClientOptions {
  /** Sent as `Authorization: Bearer …`, to a server that asks for one. */
  token?: string;
  /** Instead of the platform's own. An upload with progress uses XMLHttpRequest in browsers. */
  fetch?: typeof fetch;
  /** How often a call is tried again after 429, 503 or a lost connection; 3 without it. */
  retries?: number;
  /** Milliseconds of the longest single wait before that; 30,000 without it. */
  maxRetryWait?: number;
}

/**
 * A geodesicd server. Every method throws GeodesicError for what the server refuses,
 * NetworkError where it is not reached, and the signal's reason after an abort. Lengths
 * are in mesh units; vertices and faces are numbered as in the uploaded file.
 */
export class GeodesicClient {
  readonly #transport: Transport;

  /** @param baseUrl The server's address; without it the page's own origin. */
  constructor(baseUrl = globalThis.location?.origin, options: ClientOptions = {}) {
    if (!baseUrl) throw new TypeError('outside of a page, the address of a server is needed');
    this.#transport = new Transport(baseUrl, {
      token: options.token,
      fetch: options.fetch,
      retries: options.retries ?? 3,
      maxWait: options.maxRetryWait ?? 30_000,
    });
  }

  /**
   * Uploads a mesh, unless the server has it: its SHA-256 is asked for first. A file's bytes,
   * `[{name, data}]` for a `.gltf` with its buffers, `{positions, index}`, or a three.js
   * `BufferGeometry`; the last two go as a binary PLY. A `File` brings its name along.
   */
  upload(data: uploads.Uploadable, options: uploads.UploadOptions = {}): Promise<MeshMetadata> {
    return uploads.upload(this.#transport, data, options);
  }

  /** The same, with the progress of the server's part too: decoding and checking, as a job. */
  uploadJob(data: uploads.Uploadable, options: uploads.UploadJobOptions = {}): Promise<MeshMetadata> {
    return uploads.uploadAsJob(this.#transport, data, options);
  }

  /** All meshes in the order of their ids, fetched `limit` at a time (1 to 1000). */
  async *meshes(options: CallOptions & { limit?: number } = {}): AsyncGenerator<MeshMetadata> {
    let cursor: string | null = null;
    do {
      const search = new URLSearchParams();
      if (options.limit !== undefined) search.set('limit', String(options.limit));
      if (cursor !== null) search.set('cursor', cursor);
      const path = `/v1/meshes?${search}`;
      const page: Schemas['MeshPage'] = await this.#json({ method: 'GET', path, ...signalOf(options) });
      yield* page.meshes;
      cursor = page.next;
    } while (cursor !== null);
  }

  /** The first `limit` meshes (1 to 1000; 100 without it) as a plain array. */
  async list(options: CallOptions & { limit?: number } = {}): Promise<MeshMetadata[]> {
    const { limit = 100 } = options;
    const path = `/v1/meshes?limit=${limit}`;
    return (await this.#json<Schemas['MeshPage']>({ method: 'GET', path, ...signalOf(options) })).meshes;
  }

  /** What is known of a mesh. */
  mesh(id: string, options: CallOptions = {}): Promise<MeshMetadata> {
    return this.#json({ method: 'GET', path: meshPath(id), ...signalOf(options) });
  }

  /**
   * Gives a mesh a name, in place of one that it has: up to 200 bytes of UTF-8 without control
   * characters. An empty name takes it away. Resolves to the metadata with the new name.
   */
  renameMesh(id: string, name: string, options: CallOptions = {}): Promise<MeshMetadata> {
    return uploads.rename(this.#transport, id, name, options.signal);
  }

  /** The server forgets the mesh and its file. */
  async deleteMesh(id: string, options: CallOptions = {}): Promise<void> {
    await this.#transport.exchange({ method: 'DELETE', path: meshPath(id), ...signalOf(options) });
  }

  /** The very bytes that were uploaded, with their media type. */
  async source(id: string, options: CallOptions = {}): Promise<Blob> {
    const path = meshPath(id, 'source');
    return replies.blobOf(
      await this.#transport.exchange({ method: 'GET', path, ...signalOf(options) }),
    );
  }

  /**
   * What the server computes on; `values: 'f64'` for positions as they are there. `onArrival`
   * sees a large mesh before it is there whole: it is called with all positions and the
   * triangles so far, again and again as more come.
   */
  async geometry<P extends Precision = 'f32'>(
    id: string,
    options: CallOptions & { values?: P; onArrival?: (part: ArrivingGeometry) => void } = {},
  ): Promise<queries.Geometry<P>> {
    const call = queryCall(id, 'geometry', { format: 'frame' }, signalOf(options));
    const precision = (options.values ?? 'f32') as P;
    const reply = options.onArrival
      ? await exchangeGeometry(this.#transport, call, options.onArrival)
      : await this.#transport.exchange(call);
    return replies.geometryOf(reply, precision);
  }

  /** Builds what queries need, so that the first of them is quick. */
  prepare(id: string, options: CallOptions = {}): Promise<MeshMetadata> {
    return this.#run(planOf(id, { query: 'prepare' }, options));
  }

  /** The geodesic methods that the server has. */
  async methods(options: CallOptions = {}): Promise<MethodInfo[]> {
    const path = '/v1/methods';
    return (await this.#json<Schemas['Methods']>({ method: 'GET', path, ...signalOf(options) }))
      .methods;
  }

  /** The server's version, limits, load and caches. */
  status(options: CallOptions = {}): Promise<Status> {
    return this.#json({ method: 'GET', path: '/v1/status', ...signalOf(options) });
  }

  /** The distance of every source vertex from the nearest source. */
  distance<P extends Precision = 'f32'>(
    id: string,
    query: queries.DistanceQuery,
    options: QueryOptions & { values?: P } = {},
  ): Promise<queries.Field<P>> {
    return this.#run(fieldPlan(id, query, (options.values ?? 'f32') as P, options));
  }

  /** The distances of a few points only, in JSON: null where unreached. */
  async distancesAt(
    id: string,
    query: queries.DistancesAtQuery,
    options: QueryOptions = {},
  ): Promise<queries.DistancesAt> {
    return this.#run(planOf(id, { query: 'distancesAt', ...query }, options));
  }

  /** The shortest path from one point to another; `reachable` is false where there is none. */
  path(id: string, query: queries.PathQuery, options: QueryOptions = {}): Promise<queries.Path> {
    return this.#run(planOf(id, { query: 'path', ...query }, options));
  }

  /**
   * Distances from each of several points to each of several others. A table that is over the
   * server's limits is several requests, one after the other, and `deadlineMs` is for the whole.
   */
  table(id: string, query: queries.TableQuery, options: QueryOptions = {}): Promise<queries.Table> {
    return table(this.#transport, id, query, options);
  }

  /**
   * The rows of a table of thousands, each as the server has computed it. Where the connection
   * breaks, it goes on with the row that is missing.
   */
  tableRows(
    id: string,
    query: queries.TableRowsQuery,
    options: QueryOptions = {},
  ): AsyncGenerator<queries.TableRow, void, undefined> {
    return tableRows(this.#transport, id, query, options);
  }

  /** What of a table is not farther than `max`: near distances among many points. */
  sparseTable(
    id: string,
    query: queries.SparseTableQuery,
    options: QueryOptions = {},
  ): Promise<queries.SparseTable> {
    return sparseTable(this.#transport, id, query, options);
  }

  /** Lines of equal distance. */
  isolines(
    id: string,
    query: queries.IsolinesQuery,
    options: QueryOptions = {},
  ): Promise<queries.Isolines> {
    return this.#run(planOf(id, { query: 'isolines', ...query }, options));
  }

  /** Where on the surface points are: snapped from space, or hit by a ray. */
  nearest(
    id: string,
    query: queries.NearestQuery,
    options: QueryOptions = {},
  ): Promise<queries.Nearest> {
    return this.#run(planOf(id, { query: 'nearest', ...query }, options));
  }

  /** Straight ahead on the surface: a straightest geodesic. */
  trace(id: string, query: queries.TraceQuery, options: QueryOptions = {}): Promise<queries.Trace> {
    return this.#run(planOf(id, { query: 'trace', ...query }, options));
  }

  /** A closed curve: through points, a closed geodesic round something, or a tape about a section. */
  loop(id: string, query: queries.LoopQuery, options: QueryOptions = {}): Promise<queries.Loop> {
    return this.#run(planOf(id, { query: 'loop', ...query }, options));
  }

  /** The surface round a point, laid into the plane: for decals and patterns about it. */
  logmap(id: string, query: queries.LogmapQuery, options: QueryOptions = {}): Promise<queries.Logmap> {
    return this.#run(planOf(id, { query: 'logmap', ...query }, options));
  }

  /** What geodesic discs measure: areas, outlines, the greatest distance and the mean. */
  measure(
    id: string,
    query: queries.MeasureQuery,
    options: QueryOptions = {},
  ): Promise<queries.Measure> {
    return this.#run(planOf(id, { query: 'measure', ...query }, options));
  }

  /** How large the surface is, or where its middle is, with bounds. */
  extent(id: string, query: queries.ExtentQuery, options: QueryOptions = {}): Promise<queries.Extent> {
    return this.#run(planOf(id, { query: 'extent', ...query }, options));
  }

  /** The cells of the nearest of some sites, their bisectors, and the triangles between sites. */
  voronoi(
    id: string,
    query: queries.VoronoiQuery,
    options: QueryOptions = {},
  ): Promise<queries.Voronoi> {
    return this.#run(planOf(id, { query: 'voronoi', ...query }, options));
  }

  /** Vertices spread evenly, by farthest-point sampling. */
  samples(
    id: string,
    query: queries.SamplesQuery,
    options: QueryOptions = {},
  ): Promise<queries.Samples> {
    return this.#run(planOf(id, { query: 'samples', ...query }, options));
  }

  /** Many queries in one request; answers in their order, as they arrive. */
  batch<Name extends QueryName>(
    id: string,
    asked: Iterable<BatchQuery<Name>>,
    options: CallOptions = {},
  ): AsyncGenerator<BatchAnswer<Name>, void, undefined> {
    return batch(this.#transport, id, asked, options);
  }

  /** A PNG of a field, a path, a trace or a loop, drawn by the server. */
  picture(id: string, query: queries.PictureQuery, options: QueryOptions = {}): Promise<Blob> {
    return this.#run(planOf(id, { query: 'picture', ...query }, options));
  }

  /**
   * A GLB: a field as a coloured mesh, lines as line strips, strips between
   * the radii of discs, a Voronoi diagram's cells, bisectors or triangles, a map's faces with
   * texture coordinates, or the geometry itself.
   */
  glb(id: string, query: queries.GlbQuery, options: QueryOptions = {}): Promise<ArrayBuffer> {
    return this.#run(planOf(id, { query: 'glb', ...query }, options));
  }

  /**
   * The `.glb` or `.gltf` that was uploaded, with a field, its labels or a map as attributes of its
   * vertices (`_GEODESIC_DISTANCE`, `_GEODESIC_SOURCE`, `_GEODESIC_LOGMAP`, or names of your own)
   * and all else as it was.
   */
  annotated(
    id: string,
    query: queries.AnnotatedQuery,
    options: QueryOptions = {},
  ): Promise<ArrayBuffer> {
    return this.#run(planOf(id, { query: 'annotated', ...query }, options));
  }

  /** A query's reply as a bare array: half the bytes of a field, but nothing about its sources. */
  async array(
    id: string,
    { of, ...query }: queries.ArrayQuery,
    options: QueryOptions = {},
  ): Promise<replies.BareArray> {
    return replies.arrayOf(await this.#transport.exchange(shownCall(id, of, query, options)));
  }

  /** A query's reply as a frame: all its arrays, and the rest of it as JSON. */
  async frame(
    id: string,
    { of, ...query }: queries.FrameQuery,
    options: QueryOptions = {},
  ): Promise<replies.ToldFrame> {
    const call = shownCall(id, of, { ...query, format: 'frame' }, options);
    return replies.frameOf(await this.#transport.exchange(call));
  }

  /**
   * A query as a job, which outlives the connection: its progress is told, an abort
   * cancels it, and it resolves to what the query's own method would.
   */
  async job<Name extends keyof queries.Queries>(
    id: string,
    ask: queries.Ask<Name>,
    options: JobOptions & { deadlineMs?: number } = {},
  ): Promise<queries.Queries[Name]['gives']> {
    const plan = planOf(id, ask, { deadlineMs: options.deadlineMs });
    return plan.read(await exchangeAsJob(this.#transport, plan.call, options));
  }

  /**
   * Any request, for what has no method here: with the token, the retries and the errors
   * of all others.
   */
  request(call: Call): Promise<Reply> {
    return this.#transport.exchange(call);
  }

  async #run<T>(plan: Plan<T>): Promise<T> {
    return plan.read(await this.#transport.exchange(plan.call));
  }

  async #json<T>(call: Call): Promise<T> {
    return replies.jsonOf<T>(await this.#transport.exchange(call));
  }
}

function signalOf({ signal }: CallOptions): CallOptions {
  return signal ? { signal } : {};
}
