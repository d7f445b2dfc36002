/**
 * A row of the table as a call of this client, each through the method that its users
 * would take, and what came of it in one shape for all.
 */
import type { GeodesicClient, Call } from 'geodesicd-client';
import type { Arguments } from './case_table.js';

/** What came of a call; of these what the client tells. */
export interface Outcome {
  status?: number;
  headers?: Headers;
  json?: unknown;
  arrays?: Record<string, OutcomeArray>;
  bytes?: { data: Uint8Array; type?: string };
  lines?: unknown[];
}

export interface OutcomeArray {
  dtype: string;
  shape: number[];
  data: ArrayLike<number>;
  max?: number | null;
}

const DTYPES: Record<string, string> = {
  Float32Array: '<f4',
  Float64Array: '<f8',
  Uint16Array: '<u2',
  Uint32Array: '<u4',
};

function plain(data: ArrayLike<number>, shape: number[]): OutcomeArray {
  return { dtype: DTYPES[data.constructor.name] ?? '', shape, data };
}

/* The table's arguments are of many types, some of them wrong on purpose. */
type Loose = any;

const BARE = new Set(['f32', 'f64', 'u16', 'npy']);

/** Carries out one call on the mesh `id` (empty where a row has none). */
export async function carryOut(
  client: GeodesicClient,
  id: string,
  call: string,
  given: Arguments,
  job: boolean,
  data: Uint8Array | undefined,
): Promise<Outcome> {
  const { format, deadline_ms: deadlineMs, ...parameters } = given as Loose;
  const options = { deadlineMs, values: 'f64' as const };
  if (call === 'request') return request(client, id, given);
  if (call === 'upload') {
    const send = job ? client.uploadJob.bind(client) : client.upload.bind(client);
    const { digest, name, ...reading } = parameters;
    return { json: await send(data as Uint8Array, { digest, name, reading }) };
  }
  if (call === 'list') {
    const meshes = [];
    for await (const mesh of client.meshes(parameters)) meshes.push(mesh);
    return { json: { meshes } };
  }
  if (call === 'batch') {
    const lines = [];
    for await (const answer of client.batch(id, parameters.lines)) lines.push(answer);
    return { lines };
  }
  if (format === 'png') {
    const ask = { of: call, ...parameters };
    if (!job) return ofBlob(await client.picture(id, ask, options));
    return ofBlob(await client.job<'picture'>(id, { query: 'picture', ...ask }));
  }
  if (format === 'annotated') {
    const file = await client.annotated(id, { of: call, ...parameters } as Loose, options);
    return { bytes: { data: new Uint8Array(file) } };
  }
  if (format === 'glb') {
    const glb = await client.glb(id, { of: call, ...parameters } as Loose, options);
    return { bytes: { data: new Uint8Array(glb) } };
  }
  if (format === 'frame') {
    const { header, arrays } = await client.frame(id, { of: call, ...parameters } as Loose, options);
    const shaped = header.arrays.map(({ name, shape }) => [name, plain(arrays[name]!, shape)]);
    return { json: header, arrays: Object.fromEntries(shaped) };
  }
  if (BARE.has(format)) {
    const array = await client.array(id, { of: call, format, ...parameters } as Loose, options);
    return { json: {}, arrays: { array } };
  }
  return natural(client, id, call, parameters, options, job);
}

/** The method that a client has for this call. */
async function natural(
  client: GeodesicClient,
  id: string,
  call: string,
  parameters: Loose,
  options: { deadlineMs: number | undefined; values: 'f64' },
  job: boolean,
): Promise<Outcome> {
  const name = call === 'distance' && parameters.at !== undefined ? 'distancesAt' : call;
  if (job) return shaped(name, await client.job(id, { query: name, ...parameters } as Loose));
  switch (name) {
    case 'mesh':
      return { json: await client.mesh(id) };
    case 'delete':
      await client.deleteMesh(id);
      return {};
    case 'source':
      return ofBlob(await client.source(id));
    case 'geometry': {
      const { positions, triangles } = await client.geometry(id, options);
      const rows = (data: ArrayLike<number>) => plain(data, [data.length / 3, 3]);
      return { arrays: { positions: rows(positions), triangles: rows(triangles) } };
    }
    case 'prepare':
      return { json: await client.prepare(id) };
    case 'methods':
      return { json: { methods: await client.methods() } };
    case 'status':
      return { json: await client.status() };
    case 'distance':
    case 'distancesAt':
    case 'path':
    case 'table':
    case 'isolines':
    case 'nearest':
    case 'trace':
    case 'loop':
    case 'logmap':
    case 'samples':
    case 'measure':
    case 'extent':
    case 'voronoi':
      return shaped(name, await client[name](id, parameters, options));
    default:
      throw new Error(`the table has a call that is not known: ${name}`);
  }
}

/** A query's value with its arrays apart. A job gives a field in float32, which is wide enough. */
function shaped(name: string, value: Loose): Outcome {
  if (name === 'distance') {
    const { values, labels, ...json } = value;
    const distances = plain(Float64Array.from(values), [values.length]);
    return { json, arrays: { distances, ...(labels && { labels: plain(labels, [labels.length]) }) } };
  }
  if (name === 'table') {
    const { distances, ...json } = value;
    const shape = [json.rows.length, json.columns.length];
    return { json, arrays: { distances: plain(distances, shape) } };
  }
  if (name === 'logmap') {
    const { vertices, distances, angles, straight, coordinates, directions, ...json } = value;
    const lists = Object.entries({ vertices, distances, angles, straight });
    const arrays = Object.fromEntries(lists.map(([key, list]) => [key, plain(list, [list.length])]));
    const carried = directions && { directions: plain(directions, [directions.length / 3, 3]) };
    return { json, arrays: { ...arrays, coordinates: plain(coordinates, [coordinates.length / 2, 2]), ...carried } };
  }
  return { json: value };
}

async function ofBlob(blob: Blob): Promise<Outcome> {
  return { bytes: { data: new Uint8Array(await blob.arrayBuffer()), type: blob.type } };
}

async function request(client: GeodesicClient, id: string, given: Arguments): Promise<Outcome> {
  const { method, path, headers, json, text } = given as Loose;
  const call: Call = { method, path: path.replaceAll('{mesh}', id), headers };
  if (json !== undefined) call.body = JSON.stringify(json);
  if (text !== undefined) call.body = text;
  const reply = await client.request(call);
  const isJson = reply.headers.get('Content-Type')?.startsWith('application/json');
  const parsed = isJson && reply.body.byteLength > 0;
  return {
    status: reply.status,
    headers: reply.headers,
    ...(parsed && { json: JSON.parse(new TextDecoder().decode(reply.body)) }),
  };
}
