/** Uploads: only what the server has not, with progress that adds up, in Node and as in a page. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { after, test } from 'node:test';
import { JSDOM } from 'jsdom';
import { GeodesicClient, NetworkError } from 'geodesicd-client';
import { FaultyProxy } from './faulty_proxy.js';
import { fixture, watchedFetch } from './fixture.js';
import { sample } from './server.js';

const { server, client } = await fixture(['--max-body-bytes', '2000000']);
const seen: string[] = [];
const watched = new GeodesicClient(server.url, { fetch: watchedFetch(seen) });
const terrain = sample('terrain.glb');
const id = createHash('sha256').update(terrain).digest('hex');
const path = `/v1/meshes/${id}`;

/** The server forgets the mesh, and the watched client its requests. */
async function anew(): Promise<void> {
  await client.deleteMesh(id).catch(() => undefined);
  seen.length = 0;
}

/** Runs with a global put in place, or taken away. */
async function having(name: string, value: unknown, act: () => Promise<void>): Promise<void> {
  const before = Object.getOwnPropertyDescriptor(globalThis, name);
  Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
  try {
    await act();
  } finally {
    if (before) Object.defineProperty(globalThis, name, before);
    else delete (globalThis as Record<string, unknown>)[name];
  }
}

/** Reports of progress that rise to the whole. How many there are is the platform's to say. */
function checkReports(reports: number[], totals: Set<number>): void {
  assert.deepEqual([...totals], [terrain.length]);
  assert.equal(reports.at(-1), terrain.length);
  assert.deepEqual(reports, [...reports].sort((a, b) => a - b));
}

async function uploadReported(using: GeodesicClient, data: Blob | Uint8Array): Promise<number> {
  const reports: number[] = [];
  const totals = new Set<number>();
  const mesh = await using.upload(data, {
    onProgress(sent, total) {
      reports.push(sent);
      totals.add(total);
    },
  });
  assert.equal(mesh.id, id);
  checkReports(reports, totals);
  return reports.length;
}

// Node 18 has no crypto.subtle, as a page of plain http.
const skip = globalThis.crypto ? false : 'this platform computes no digests';

test('what the server has is not sent again', { skip }, async () => {
  await anew();
  const first = await watched.upload(terrain);
  assert.equal(first.id, id);
  assert.deepEqual(seen, [`HEAD ${path}`, `PUT ${path}`]);
  seen.length = 0;
  const reports: [number, number][] = [];
  const again = await watched.upload(terrain, { onProgress: (...report) => reports.push(report) });
  assert.equal(again.vertices, 32400);
  assert.deepEqual(seen, [`HEAD ${path}`, `GET ${path}`]);
  assert.deepEqual(reports, [[terrain.length, terrain.length]]);
  seen.length = 0;
  await watched.upload(terrain, { digest: false });
  assert.deepEqual(seen, ['POST /v1/meshes']);
});

test('bytes of any kind, and of a part of a buffer', async () => {
  const wider = new Uint8Array(terrain.length + 20);
  wider.set(terrain, 10);
  const part = wider.subarray(10, 10 + terrain.length);
  for (const data of [terrain.slice().buffer, new Blob([terrain]), part]) {
    await anew();
    assert.equal((await client.upload(data)).id, id);
  }
  await anew();
  await uploadReported(client, part);
});

test('progress in Node adds up to the whole', async () => {
  await anew();
  assert.ok((await uploadReported(client, terrain)) > 10);
  await anew();
  assert.ok((await uploadReported(client, new Blob([terrain]))) > 10);
});

test("progress in Node goes by the client's own fetch", async () => {
  await anew();
  seen.length = 0;
  await uploadReported(watched, terrain);
  assert.ok(seen.includes(`PUT ${path}`) || seen.includes('POST /v1/meshes'), String(seen));
});

test('progress in a page, by XMLHttpRequest', async () => {
  const page = new JSDOM('', { url: `${server.url}/` });
  await having('XMLHttpRequest', page.window.XMLHttpRequest, async () => {
    await anew();
    await uploadReported(client, terrain);
    const refused = client.upload(new TextEncoder().encode('no mesh'), { onProgress: () => {} });
    await assert.rejects(refused, { status: 415, code: 'format_unknown' });
    const nobody = new GeodesicClient('http://127.0.0.1:9', { retries: 0 });
    const lost = nobody.upload(terrain, { digest: false, onProgress: () => {} });
    await assert.rejects(lost, NetworkError);
    await anew();
    const ended = new AbortController();
    const aborted = client.upload(terrain, {
      signal: ended.signal,
      onProgress: () => ended.abort(new Error('enough')),
    });
    await assert.rejects(aborted, { message: 'enough' });
  });
  page.window.close();
});

test('a page without crypto.subtle sends by POST', async () => {
  await having('crypto', undefined, async () => {
    await anew();
    assert.equal((await watched.upload(terrain)).id, id);
    assert.deepEqual(seen, ['POST /v1/meshes']);
  });
});

test('an abort ends an upload, and nothing of it remains', async () => {
  for (const told of [true, false]) {
    await anew();
    const ended = new AbortController();
    const abort = () => ended.abort();
    const upload = client.upload(terrain, {
      signal: ended.signal,
      digest: false,
      ...(told && { onProgress: abort }),
    });
    if (!told) setImmediate(abort);
    await assert.rejects(upload, { name: 'AbortError' });
    await assert.rejects(client.mesh(id), { code: 'mesh_unknown' });
  }
});

test('a file over the limit is refused by what the server says, not by a lost connection', async () => {
  const large = new Uint8Array(6_000_000);
  for (const onProgress of [undefined, () => {}]) {
    const upload = client.upload(large, { digest: false, ...(onProgress && { onProgress }) });
    await assert.rejects(upload, { status: 413, code: 'too_large', limit: 2000000 });
  }
});

test('an upload whose connection is lost is sent again, whole', async () => {
  const proxy = await FaultyProxy.before(server.url);
  after(() => proxy.stop());
  const retried = new GeodesicClient(proxy.url);
  await anew();
  proxy.faults = [{ on: '/v1/meshes', fault: { drop: true } }];
  assert.equal((await retried.upload(terrain, { digest: false })).id, id);
  await anew();
  proxy.faults = [{ on: '/v1/meshes', fault: { status: 503, headers: { 'Retry-After': '0' } } }];
  const reports: number[] = [];
  const mesh = await retried.upload(terrain, {
    digest: false,
    onProgress: (sent) => reports.push(sent),
  });
  assert.equal(mesh.id, id);
  assert.equal(reports.at(-1), terrain.length);
});

test('an upload as a job tells of both its parts', async () => {
  await anew();
  const sent: number[] = [];
  const states: string[] = [];
  const mesh = await client.uploadJob(terrain, {
    onSent: (bytes) => sent.push(bytes),
    onProgress: (job) => states.push(job.state),
  });
  assert.equal(mesh.id, id);
  assert.equal(sent.at(-1), terrain.length);
  assert.equal(states.at(-1), 'done');
  const refused = client.uploadJob(new TextEncoder().encode('no mesh'));
  await assert.rejects(refused, { status: 415, code: 'format_unknown' });
});

/** The file names of a form, with a backslash as itself (browsers) or as an escape (RFC 2183). */
function namesIn(form: string, escapes: boolean): string[] {
  const lines = form.split('\r\n').filter((line) => line.startsWith('Content-Disposition: '));
  return lines.map((line) => {
    const quoted = escapes ? /; filename="((?:[^"\\]|\\.)*)"$/.exec(line) : /; filename="([^"]*)"$/.exec(line);
    assert.ok(quoted, line);
    const name = escapes ? quoted[1]!.replace(/\\(["\\])/g, '$1') : quoted[1]!;
    return name.replace(/%22/g, '"');
  });
}

test('a file has one name in a form, however its reader takes backslashes', async () => {
  const names = ['a\\', '\\', 'a\\\\', 'a\\\\b', 'a"b\\', '\\"', 'a\\"\\', 'a\\b.bin', 'größe 100 %.bin'];
  let form = '';
  const kept = new GeodesicClient(server.url, {
    fetch: async (_, init) => {
      form = await (init!.body as Blob).text();
      return new Response('{}', { status: 201 });
    },
  });
  await kept.upload(names.map((name) => ({ name, data: new Uint8Array(3) })));
  const told = namesIn(form, true);
  assert.deepEqual(told, namesIn(form, false));
  assert.deepEqual(told, ['a/', '/', 'a//', 'a//b', 'a"b/', '\\"', 'a\\"/', 'a\\b.bin', 'größe 100 %.bin']);
});

test('files whose names end in a backslash take nothing from those beside them', async () => {
  const corners = new Uint8Array(new Float32Array([0, 0, 0, 3, 0, 0, 0, 4, 0]).buffer);
  const gltf = JSON.stringify({
    asset: { version: '2.0' }, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    buffers: [{ byteLength: 36, uri: 'data/corners.bin' }], bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [3, 4, 0] }],
  });
  const scene = { name: 'scene.gltf', data: new TextEncoder().encode(gltf) };
  for (const beside of ['notes\\', '\\', 'a"b\\']) {
    const files = [{ name: beside, data: new Uint8Array(5) }, { name: 'data/corners.bin', data: corners }, scene];
    assert.equal((await client.upload(files)).vertices, 3);
  }
});
