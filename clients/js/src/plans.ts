/**
 * A query as a plan: the request that asks it and how its reply is read. A plan can be
 * carried out at once or as a job, with the same outcome.
 */
import type { MeshMetadata, Schemas } from './contract.js';
import { slopeInUrl, weightInUrl } from './costs.js';
import { pointInJson, pointInUrl, type Source } from './points.js';
import { regionInJson, regionInUrl, wallInUrl } from './regions.js';
import type { Ask, Field, Precision, Queries, QueryOptions } from './queries.js';
import * as replies from './replies.js';
import type { Call, Reply } from './transport.js';

export interface Plan<T> {
  call: Call;
  read: (reply: Reply) => T;
}

/** Longer targets go as JSON: proxies and caches refuse long ones, each at its own bound. */
const LONGEST_TARGET = 2000;

const POINTS = new Set(['from', 'to', 'via', 'at', 'point', 'through', 'around']);
const REGIONS = new Set(['within', 'forbid', 'walls']);

type InUrl = (value: never) => string | undefined;
/** How each value of a parameter stands in a URL; those of any other as `plain` says. */
const EACH_IN_URL = new Map<string, InUrl>([
  ...[...POINTS].map((name): [string, InUrl] => [name, pointInUrl]),
  ['within', regionInUrl],
  ['forbid', regionInUrl],
  ['walls', wallInUrl],
  ['weights', weightInUrl],
]);
/** Of parameters whose value, be it an array, is one. */
const WHOLE_IN_URL = new Map<string, InUrl>([
  ['direction', vectorInUrl],
  ['normal', vectorInUrl],
  ['up', vectorInUrl],
  ['slope', slopeInUrl],
]);

/** The path of a mesh or of what is below it. */
export function meshPath(id: string, below = ''): string {
  return `/v1/meshes/${encodeURIComponent(id)}${below && `/${below}`}`;
}

/** The request of any query: GET, which browsers cache, where its grammar can say it. */
export function queryCall(
  id: string,
  name: string,
  parameters: object,
  options: QueryOptions = {},
): Call {
  const all: Record<string, unknown> = { ...parameters, deadline_ms: options.deadlineMs };
  const entries = Object.entries(all).filter(([, value]) => value !== undefined);
  const search = inUrl(entries);
  const path = meshPath(id, name);
  if (search !== undefined && path.length + 1 + search.length <= LONGEST_TARGET) {
    return { method: 'GET', path: search ? `${path}?${search}` : path, signal: options.signal };
  }
  return {
    method: 'POST',
    path,
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify(parametersInJson(Object.fromEntries(entries))),
    idempotent: true, // it asks, and changes nothing
    signal: options.signal,
  };
}

/** A query's parameters with each point in its JSON form. */
export function parametersInJson(parameters: object): Record<string, unknown> {
  const body: Record<string, unknown> = {};
  for (const [name, value] of Object.entries(parameters)) {
    if (REGIONS.has(name)) body[name] = regionInJson(value);
    else if (!POINTS.has(name)) body[name] = value;
    else body[name] = Array.isArray(value) ? value.map(pointInJson) : pointInJson(value as Source);
  }
  return body;
}

function inUrl(entries: [string, unknown][]): string | undefined {
  const search = new URLSearchParams();
  for (const [name, value] of entries) {
    const whole = WHOLE_IN_URL.get(name);
    if (REGIONS.has(name) && Array.isArray(value) && value.length === 0) return undefined;
    for (const one of Array.isArray(value) && !whole ? value : [value]) {
      const text = (whole ?? EACH_IN_URL.get(name) ?? plain)(one as never);
      if (text === undefined) return undefined;
      search.append(name, text);
    }
  }
  // Only what must be is escaped: `from=v:0` is what people read in their network panel.
  return search.toString().replaceAll('%3A', ':').replaceAll('%2C', ',').replaceAll('%3B', ';');
}

function vectorInUrl(value: unknown): string {
  return Array.isArray(value) ? value.join(',') : String(value);
}

function plain(value: unknown): string | undefined {
  if (typeof value === 'boolean') return value ? '1' : '0';
  return typeof value === 'object' ? undefined : String(value);
}

/** Planning any query; `precision` is that of a field's values. */
export function planOf<Name extends keyof Queries>(
  id: string,
  ask: Ask<Name>,
  options: QueryOptions,
): Plan<Queries[Name]['gives']> {
  const { query, ...parameters } = ask as { query: Name } & Record<string, unknown>;
  return PLANS[query](id, parameters, options) as Plan<Queries[Name]['gives']>;
}

type Planner = (id: string, parameters: Record<string, unknown>, options: QueryOptions) => Plan<unknown>;

const json =
  (name: string): Planner =>
  (id, parameters, options) => ({
    call: queryCall(id, name, parameters, options),
    read: replies.jsonAnswer,
  });

/** A query in another format than its own. Means are shown as what they are: one of the extents. */
export function shownCall(id: string, of: unknown, parameters: object, options: QueryOptions): Call {
  return of === 'means'
    ? queryCall(id, 'extent', { ...parameters, of }, options)
    : queryCall(id, String(of), parameters, options);
}

const PLANS: Record<keyof Queries, Planner> = {
  distance: (id, parameters, options) => fieldPlan(id, parameters, 'f32', options),
  distancesAt(id, parameters, options) {
    const at = parameters['at'];
    // The server takes none for all; whoever computes a list means the list.
    if (at === undefined || (Array.isArray(at) && at.length === 0)) {
      throw new RangeError('distancesAt needs a point in `at`');
    }
    return json('distance')(id, parameters, options);
  },
  path: json('path'),
  isolines: json('isolines'),
  nearest: json('nearest'),
  trace: json('trace'),
  loop: json('loop'),
  samples: json('samples'),
  measure: json('measure'),
  extent: json('extent'),
  voronoi: json('voronoi'),
  table: (id, parameters, options) => ({
    call: queryCall(id, 'table', { ...parameters, format: 'frame' }, options),
    read: replies.tableOf,
  }),
  logmap: (id, parameters, options) => ({
    call: queryCall(id, 'logmap', { ...parameters, format: 'frame' }, options),
    read: replies.logmapOf,
  }),
  picture: (id, { of, ...parameters }, options) => ({
    call: shownCall(id, of, { ...parameters, format: 'png' }, options),
    read: replies.blobOf,
  }),
  glb: (id, { of, ...parameters }, options) => ({
    call: shownCall(id, of, { ...parameters, format: 'glb' }, options),
    read: (reply) => reply.body,
  }),
  annotated: (id, { of, ...parameters }, options) => ({
    call: shownCall(id, of, { ...parameters, format: 'annotated' }, options),
    read: (reply) => reply.body,
  }),
  prepare: (id, _parameters, options) => preparePlan(id, options),
};

export function fieldPlan<P extends Precision>(
  id: string,
  parameters: object,
  precision: P,
  options: QueryOptions,
): Plan<Field<P>> {
  return {
    call: queryCall(id, 'distance', { ...parameters, format: 'frame' }, options),
    read: (reply) => replies.fieldOf(reply, precision),
  };
}

function preparePlan(id: string, options: QueryOptions): Plan<MeshMetadata> {
  return {
    call: {
      method: 'POST',
      path: meshPath(id, 'prepare'),
      idempotent: true, // prepared twice is prepared
      signal: options.signal,
    },
    read: (reply) => replies.jsonOf<Schemas['Mesh']>(reply),
  };
}
