/** What to do next about an error, where the server's own sentence does not say it. */
import type { ErrorCode } from './contract.js';

const NO_USE = 'Asking again will not help: ';
const TOKEN = 'new GeodesicClient(url, { token })';

const OF_CODE: Partial<Record<ErrorCode, string>> = {
  mesh_unknown: 'Upload it, again if it was deleted. client.meshes() tells what is there',
  unauthorized: `Give a token: ${TOKEN}`,
  forbidden: `Give a token with that scope: ${TOKEN}`,
  method_unknown: 'client.methods() lists them',
  too_many_vertices: 'Simplify the mesh, or start the server with a larger --max-vertices',
  too_many_faces: 'Simplify the mesh, or start the server with a larger --max-faces',
  external_uri: 'Upload the .gltf with the files that it names: upload([{ name, data }, …])',
  format_unknown: 'three.js loads other formats, and upload takes its BufferGeometry',
  snap_too_far: 'Are units and axes those of the mesh? If so, give a larger max_snap',
  outside_region: 'A place, such as { xyz }, finds the closest point of what is left',
  no_hit: "The mesh's bbox says where it is",
  no_loop: 'A loop goes round a handle, a waist or a limb; a path needs none',
  store_full: `${NO_USE}delete meshes, or give the server a larger --store-max-bytes or disk`,
  deadline: 'Give a longer deadlineMs, or a method that is faster',
  request_timeout: 'The request came too slowly: ask again, or over a faster network',
  overloaded: 'Ask later, or give the client more patience: { retries, maxRetryWait }',
  too_many_requests: 'Ask for less at a time, or later: { retries, maxRetryWait }',
  draining: 'The server is about to stop: ask again once it has been started',
  store_unavailable: 'Ask later: the server cannot reach where it keeps its meshes',
  internal: "This is a fault of the server's: its log says more, under the request's name",
};

const BETWEEN = "This is no reply of geodesicd's own";
const OF_STATUS: Record<number, string> = {
  401: `${BETWEEN}: what is before the server wants to know who asks. Give a token: ${TOKEN}`,
  403: `${BETWEEN}: what is before the server does not let this through`,
  413: `${NO_USE}what is before the server takes no body so large, such as nginx's client_max_body_size`,
  429: `${BETWEEN}: what is before the server wants fewer requests. Ask later`,
  502: `${BETWEEN}: what is before the server does not reach it. Is it running?`,
  503: `${BETWEEN}: what is before the server does not reach it. Ask later`,
  504: `${BETWEEN}: what is before the server waited too long. Ask as a job: client.job()`,
  507: `${NO_USE}what is before the server has no room`,
};

/** What to do about a refusal; undefined where its detail says it. */
export function hintOfError(
  status: number,
  code: ErrorCode | 'unrecognised',
  detail: string,
  limit: number | undefined,
): string | undefined {
  if (code === 'unrecognised') {
    return OF_STATUS[status] ?? `${BETWEEN}: is that address one, and what is between?`;
  }
  if (code === 'too_large') return NO_USE + smaller(detail);
  if (code === 'too_much_memory') return NO_USE + cheaper(detail);
  if (code === 'index_out_of_range' && limit !== undefined) {
    return `Vertices and faces are counted from 0; the last is ${limit}`;
  }
  return OF_CODE[code];
}

function smaller(detail: string): string {
  // A job's reply is kept until it is fetched.
  if (detail.includes('kept')) {
    return 'ask without a job, or start the server with a larger --job-result-bytes';
  }
  if (detail.includes('body')) {
    return (
      'send less at once, or start the server with a larger --max-body-bytes (for queries ' +
      '--max-json-bytes)'
    );
  }
  return 'ask for less at once: (await client.status()).limits says how much is taken';
}

function cheaper(detail: string): string {
  if (detail.includes('reply')) {
    return 'ask for less (max), or start the server with a larger --reply-memory-bytes';
  }
  return (
    "give method: 'auto', a tolerance or a nearer max, or start the server with a larger " +
    '--query-memory-bytes'
  );
}
