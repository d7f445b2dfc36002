/** Replies to queries as values: JSON as it is, binary as typed arrays. */
import { countOf, viewAs, type Shaped } from './arrays.js';
import type { CostUnit, Method, ResolvedPoint } from './contract.js';
import { decodeFrame, type Frame } from './frame.js';
import { decodeNpy } from './npy.js';
import type {
  Field,
  Floats,
  Geometry,
  Logmap,
  Precision,
  SparseTable,
  Table,
  Timing,
  Told,
} from './queries.js';
import type { Reply } from './transport.js';

/** A bare array with what its headers say. */
export interface BareArray extends Shaped, Told {
  /** The greatest finite distance; null where the reply does not say. Mesh units. */
  max: number | null;
  /** The length of a path or a trace; null where the reply does not say. Mesh units. */
  length: number | null;
}

/** A decoded frame with what its headers say. */
export type ToldFrame = Frame & Told;

/** The stages and milliseconds of a `Server-Timing` header. */
export function parseTiming(header: string | null): Timing {
  const timing: Record<string, number> = {};
  for (const entry of header?.split(',') ?? []) {
    const [name, ...details] = entry.split(';').map((part) => part.trim());
    const milliseconds = details.find((part) => part.startsWith('dur='));
    if (name && milliseconds) timing[name] = Number(milliseconds.slice(4));
  }
  return timing;
}

/** The sentences of `warnings` in a reply's JSON, or of a `Geo-Warnings` header where it has none. */
export function warningsIn(json: unknown, header: string | null = null): string[] {
  const listed = (json as { warnings?: unknown } | null)?.warnings;
  if (Array.isArray(listed)) return listed.map(String);
  return header?.split('; ').filter(Boolean) ?? [];
}

/** What a reply's headers say; its warnings better out of its `json`, where it has some. */
export function told(reply: Reply, json?: unknown): Told {
  const cache = reply.headers.get('Geo-Cache');
  return {
    timing: parseTiming(reply.headers.get('Server-Timing')),
    cache: cache === 'hit' || cache === 'miss' ? cache : null,
    warnings: warningsIn(json, reply.headers.get('Geo-Warnings')),
  };
}

export function jsonOf<T>(reply: Reply): T {
  return JSON.parse(new TextDecoder().decode(reply.body)) as T;
}

export function jsonAnswer<T>(reply: Reply): T & Told {
  const json = jsonOf<T>(reply);
  return { ...json, ...told(reply, json) };
}

/** Numbers in the precision asked for; float64 comes without a copy. */
function floats<P extends Precision>(values: Float64Array, precision: P): Floats<P> {
  return (precision === 'f64' ? values : new Float32Array(values)) as Floats<P>;
}

/** What costs are in, of a reply that has costs. */
function unitIn(header: Readonly<Record<string, unknown>>): { unit?: CostUnit } {
  return header['unit'] === undefined ? {} : { unit: header['unit'] as CostUnit };
}

export function fieldOf<P extends Precision>(reply: Reply, precision: P): Field<P> {
  const { header, arrays } = decodeFrame(reply.body);
  const field: Field<P> = {
    mesh: header['mesh'] as string,
    method: header['method'] as Method,
    from: header['from'] as ResolvedPoint[],
    values: floats(arrays['distances'] as Float64Array, precision),
    reached: header['reached'] as number,
    max: header['max'] as number | null,
    farthest: header['farthest'] as number | null,
    ...unitIn(header),
    ...(header['signed'] === true && { signed: true as const }),
    ...told(reply, header),
  };
  if (arrays['labels']) field.labels = arrays['labels'] as Uint32Array;
  return field;
}

export function tableOf(reply: Reply): Table {
  const { header, arrays } = decodeFrame(reply.body);
  return {
    mesh: header['mesh'] as string,
    method: header['method'] as Method,
    rows: header['rows'] as ResolvedPoint[],
    columns: header['columns'] as ResolvedPoint[],
    distances: arrays['distances'] as Float64Array,
    ...unitIn(header),
    ...told(reply, header),
  };
}

export function sparseTableOf(reply: Reply): SparseTable {
  const { header, arrays } = decodeFrame(reply.body);
  return {
    mesh: header['mesh'] as string,
    method: header['method'] as Method,
    rows: header['rows'] as ResolvedPoint[],
    columns: header['columns'] as ResolvedPoint[],
    data: arrays['data'] as Float64Array,
    indices: arrays['indices'] as Uint32Array,
    indptr: arrays['indptr'] as Uint32Array,
    ...unitIn(header),
    ...told(reply, header),
  };
}

export function logmapOf(reply: Reply): Logmap {
  const { header, arrays } = decodeFrame(reply.body);
  return {
    mesh: header['mesh'] as string,
    method: header['method'] as Method,
    from: header['from'] as ResolvedPoint,
    angle: header['angle'] as number,
    radius: header['radius'] as number,
    total_angle: header['total_angle'] as number,
    all_round: header['all_round'] as boolean,
    vertices: arrays['vertices'] as Uint32Array,
    distances: arrays['distances'] as Float64Array,
    angles: arrays['angles'] as Float64Array,
    straight: arrays['straight'] as Uint32Array,
    coordinates: arrays['coordinates'] as Float64Array,
    ...(arrays['directions'] && { directions: arrays['directions'] as Float64Array }),
    ...told(reply, header),
  };
}

export function geometryOf<P extends Precision>(reply: Reply, precision: P): Geometry<P> {
  const { arrays } = decodeFrame(reply.body);
  return {
    positions: floats(arrays['positions'] as Float64Array, precision),
    triangles: arrays['triangles'] as Uint32Array,
  };
}

export function frameOf(reply: Reply): ToldFrame {
  const frame = decodeFrame(reply.body);
  return { ...frame, ...told(reply, frame.header) };
}

export function arrayOf(reply: Reply): BareArray {
  const number = (name: string) => {
    const text = reply.headers.get(name);
    return text === null ? null : Number(text);
  };
  return {
    ...shapedOf(reply),
    max: number('Geo-Max'),
    length: number('Geo-Length'),
    ...told(reply),
  };
}

function shapedOf(reply: Reply): Shaped {
  if (reply.headers.get('Content-Type') === 'application/x-npy') return decodeNpy(reply.body);
  const dtype = reply.headers.get('Geo-Dtype') ?? '';
  const shape = (reply.headers.get('Geo-Shape') ?? '').split(',').filter(Boolean).map(Number);
  return { dtype, shape, data: viewAs(reply.body, dtype, 0, countOf(shape)) };
}

export function blobOf(reply: Reply): Blob {
  return new Blob([reply.body], { type: reply.headers.get('Content-Type') ?? '' });
}
