/**
 * Uploads, the digest first: a mesh's id is the SHA-256 of its file, so whoever can
 * compute it need not send what the server has.
 */
import type { MeshMetadata } from './contract.js';
import { GeodesicError } from './errors.js';
import { exchangeAsJob, type JobOptions } from './jobs.js';
import { meshPath } from './plans.js';
import { jsonOf } from './replies.js';
import type { Call, Reply, Sender, Transport } from './transport.js';
import { senderWithProgress } from './upload_progress.js';

/** The bytes of a `.glb`, `.gltf` with embedded data, `.drc`, `.obj`, `.ply` or `.stl`. */
export type MeshData = Blob | ArrayBuffer | Uint8Array;

/** How a file is to be read. The same file read in two ways is two meshes. */
export interface Reading {
  /** Of a glTF file, by index or name; else its default scene. */
  scene?: number | string | undefined;
  /** Of a glTF file: what it and its children draw, and nothing else. */
  node?: number | string | undefined;
  /** Vertices at most so far apart become one; 0 without it, `'off'` for none. */
  weld?: number | 'off' | undefined;
  /** The axis that points up in the file; `'y'` without it, as in glTF. */
  up?: 'x' | 'y' | 'z' | undefined;
  /** All positions times this, such as 0.001 for millimetres that are to be metres. */
  scale?: number | undefined;
}

export interface UploadOptions {
  reading?: Reading | undefined;
  /** Told of the bytes that have left; once with all where the server had the mesh. */
  onProgress?: ((sentBytes: number, totalBytes: number) => void) | undefined;
  signal?: AbortSignal | undefined;
  /** False: send the bytes without asking whether the server has them. */
  digest?: boolean | undefined;
}

export interface UploadJobOptions extends Omit<UploadOptions, 'onProgress'> {
  /** Told of the bytes that have left. */
  onSent?: ((sentBytes: number, totalBytes: number) => void) | undefined;
  /** Told of the job that decodes and checks the mesh, once all bytes have left. */
  onProgress?: JobOptions['onProgress'];
}

/** Sends a mesh unless the server has it. */
export async function upload(
  transport: Transport,
  data: MeshData,
  options: UploadOptions,
): Promise<MeshMetadata> {
  return uploadBy(transport, data, options, (call, sender) => transport.exchange(call, sender));
}

/** The same, the server's part of it as a job. */
export async function uploadAsJob(
  transport: Transport,
  data: MeshData,
  { onSent, onProgress, ...options }: UploadJobOptions,
): Promise<MeshMetadata> {
  return uploadBy(transport, data, { ...options, onProgress: onSent }, (call, sender) =>
    exchangeAsJob(transport, call, { onProgress, signal: options.signal }, sender),
  );
}

async function uploadBy(
  transport: Transport,
  data: MeshData,
  options: UploadOptions,
  send: (call: Call, sender: Sender | undefined) => Promise<Reply>,
): Promise<MeshMetadata> {
  const { onProgress, signal } = options;
  signal?.throwIfAborted();
  const total = data instanceof Blob ? data.size : data.byteLength;
  const id = options.digest === false ? undefined : await digestOf(data);
  signal?.throwIfAborted();
  const search = searchOf(options.reading ?? {});
  // What id a file has that is read in a way of its own, the server tells.
  if (id !== undefined && search === '') {
    const known = await lookUp(transport, id, signal);
    if (known) {
      onProgress?.(total, total);
      return known;
    }
  }
  const call: Call = {
    method: id === undefined ? 'POST' : 'PUT',
    path: (id === undefined ? '/v1/meshes' : meshPath(id)) + search,
    headers: { 'Content-Type': 'application/octet-stream' },
    body: data,
    idempotent: true, // the same bytes are the same mesh, by POST too
    signal,
  };
  return jsonOf<MeshMetadata>(await send(call, onProgress && senderWithProgress(onProgress)));
}

function searchOf(reading: Reading): string {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(reading)) {
    if (value !== undefined) search.set(name, String(value));
  }
  return search.size === 0 ? '' : `?${search}`;
}

/**
 * The SHA-256 in hexadecimal; undefined where the platform has none, as pages of plain
 * http do (but for localhost) and Node 18.
 */
export async function digestOf(data: MeshData): Promise<string | undefined> {
  const subtle = globalThis.crypto?.subtle;
  if (!subtle) return undefined;
  const bytes = data instanceof Blob ? await data.arrayBuffer() : (data as BufferSource);
  const digest = new Uint8Array(await subtle.digest('SHA-256', bytes));
  return Array.from(digest, (byte) => byte.toString(16).padStart(2, '0')).join('');
}

/** The metadata of a mesh that the server has; undefined if not, or if it may not say. */
async function lookUp(
  transport: Transport,
  id: string,
  signal: AbortSignal | undefined,
): Promise<MeshMetadata | undefined> {
  try {
    await transport.exchange({ method: 'HEAD', path: meshPath(id), signal });
    return jsonOf(await transport.exchange({ method: 'GET', path: meshPath(id), signal }));
  } catch (error) {
    // Deleted between the two, or a token that may upload and not read: then it is sent.
    const sendIt = error instanceof GeodesicError && (error.status === 404 || error.status === 403);
    if (sendIt) return undefined;
    throw error;
  }
}
