/**
 * Uploads, the digest first: a mesh's id is the SHA-256 of its file, so whoever can
 * compute it need not send what the server has.
 */
import type { MeshMetadata } from './contract.js';
import { GeodesicError } from './errors.js';
import { exchangeAsJob, type JobOptions } from './jobs.js';
import { fileName } from './names.js';
import { meshPath } from './plans.js';
import { plyOf, type GeometryLike, type MeshArrays } from './ply.js';
import { jsonOf } from './replies.js';
import type { Call, Reply, Sender, Transport } from './transport.js';
import { senderWithProgress } from './upload_progress.js';

/** The bytes of a `.glb`, `.gltf` with embedded data, `.drc`, `.obj`, `.ply` or `.stl`. */
export type MeshData = Blob | ArrayBuffer | Uint8Array;

/** A file among several; the name is the one that a `.gltf` knows it by. */
export interface NamedFile {
  name: string;
  data: MeshData;
}

/**
 * What `upload` takes: a file's bytes, a `.gltf` with the files of its buffers, arrays, or a
 * three.js `BufferGeometry`.
 */
export type Uploadable = MeshData | readonly NamedFile[] | MeshArrays | GeometryLike;

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
  /**
   * What to call the mesh: up to 200 bytes of UTF-8 without control characters. Without it a
   * `File` is called by its own name, and a `.gltf` with its buffers by that of the `.gltf`.
   * A mesh that has a name keeps it; `renameMesh` gives it another. An upload fails for a name only
   * where it is this one.
   */
  name?: string | undefined;
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
  data: Uploadable,
  options: UploadOptions,
): Promise<MeshMetadata> {
  return uploadBy(transport, data, options, (call, sender) => transport.exchange(call, sender));
}

/** The same, the server's part of it as a job. */
export async function uploadAsJob(
  transport: Transport,
  data: Uploadable,
  { onSent, onProgress, ...options }: UploadJobOptions,
): Promise<MeshMetadata> {
  return uploadBy(transport, data, { ...options, onProgress: onSent }, (call, sender) =>
    exchangeAsJob(transport, call, { onProgress, signal: options.signal }, sender),
  );
}

async function uploadBy(
  transport: Transport,
  mesh: Uploadable,
  options: UploadOptions,
  send: (call: Call, sender: Sender | undefined) => Promise<Reply>,
): Promise<MeshMetadata> {
  const { onProgress, signal } = options;
  signal?.throwIfAborted();
  if (typeof mesh === 'string') {
    throw new TypeError('an address is no mesh: fetch it, and give the bytes: await (await fetch(address)).arrayBuffer()');
  }
  const form = isForm(mesh) ? formOf(mesh) : undefined;
  const data = isForm(mesh) ? form!.body : isFile(mesh) ? mesh : plyOf(mesh);
  const total = data instanceof Blob ? data.size : data.byteLength;
  // Of a form the mesh is what the server packs.
  const id = form || options.digest === false ? undefined : await digestOf(data);
  signal?.throwIfAborted();
  const reading = searchOf({ ...options.reading });
  const name = options.name ?? nameIn(mesh);
  // What id a file has that is read in a way of its own, the server tells.
  if (id !== undefined && reading === '') {
    const known = await lookUp(transport, id, signal);
    if (known) {
      onProgress?.(total, total);
      return known.name === undefined && name ? await named(transport, known, options, name) : known;
    }
  }
  const search = searchOf({ ...options.reading, name: name || undefined });
  const call: Call = {
    method: id === undefined ? 'POST' : 'PUT',
    path: (id === undefined ? '/v1/meshes' : meshPath(id)) + search,
    headers: { 'Content-Type': form?.type ?? 'application/octet-stream' },
    body: data,
    idempotent: true, // the same bytes are the same mesh, by POST too
    signal,
  };
  return jsonOf<MeshMetadata>(await send(call, onProgress && senderWithProgress(transport, onProgress)));
}

/**
 * A mesh that the server has without a name gets one. The mesh is there without it, so that only a
 * name that was asked for is worth an error; and an abort is one.
 */
async function named(
  transport: Transport,
  known: MeshMetadata,
  options: UploadOptions,
  name: string,
): Promise<MeshMetadata> {
  try {
    return await rename(transport, known.id, name, options.signal);
  } catch (error) {
    if (options.name !== undefined || options.signal?.aborted) throw error;
    return known;
  }
}

/** Gives a mesh a name in place of the one that it has; an empty one takes that away. */
export async function rename(
  transport: Transport,
  id: string,
  name: string,
  signal: AbortSignal | undefined,
): Promise<MeshMetadata> {
  const call: Call = {
    method: 'PATCH',
    path: meshPath(id),
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify({ name }),
    idempotent: true, // the same name again is the same name
    signal,
  };
  return jsonOf<MeshMetadata>(await transport.exchange(call));
}

/** The name that a `File` has, or the `.gltf` among several. */
function nameIn(mesh: Uploadable): string | undefined {
  if (isForm(mesh)) return fileName(mesh.find(({ name }) => /\.gltf$/i.test(name)) ?? {});
  return mesh instanceof Blob ? fileName(mesh as { name?: unknown }) : undefined;
}

function isForm(mesh: Uploadable): mesh is readonly NamedFile[] {
  return Array.isArray(mesh);
}

/**
 * In quotes, some read a backslash as itself and others as an escape of the next character. They
 * differ where that is the closing quote or another backslash.
 */
const AMBIGUOUS = /\\+$|\\{2,}/g;

/** By hand, since forms of browsers keep no folders in names, and Node 18 has none with them. */
function formOf(files: readonly NamedFile[]): { body: Blob; type: string } {
  const boundary = `geodesicd${Array.from({ length: 3 }, () => Math.random().toString(36).slice(2)).join('')}`;
  const quoted = (name: string) =>
    name.replace(AMBIGUOUS, (run) => '/'.repeat(run.length)).replace(/["\r\n]/g, encodeURIComponent);
  const parts = files.flatMap(({ name, data }) => [
    `--${boundary}\r\nContent-Disposition: form-data; name="files"; filename="${quoted(name)}"\r\n\r\n`,
    data as BlobPart,
    '\r\n',
  ]);
  return { body: new Blob([...parts, `--${boundary}--\r\n`]), type: `multipart/form-data; boundary=${boundary}` };
}

function isFile(mesh: Exclude<Uploadable, readonly NamedFile[]>): mesh is MeshData {
  return !('positions' in mesh) && !('getAttribute' in mesh);
}

function searchOf(parameters: Reading & { name?: string | undefined }): string {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(parameters)) {
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
