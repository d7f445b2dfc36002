/** An error's sentence says what was wrong, where, by how much, and what to do next. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GeodesicClient, GeodesicError } from 'geodesicd-client';
import { fixture } from './fixture.js';
import { Server } from './server.js';

const { server, client, plane } = await fixture();
const host = new URL(server.url).host;

async function refusal(ask: Promise<unknown>): Promise<GeodesicError> {
  const error = await ask.then(() => undefined, (reason: unknown) => reason);
  assert.ok(error instanceof GeodesicError);
  return error;
}

test('parameter, limit, request, server and what to do next', async () => {
  const error = await refusal(client.path(plane, { from: 0, to: 123456 }));
  assert.equal(error.server, host);
  assert.equal(
    error.message,
    'index_out_of_range: the mesh has no such vertex ' +
      `(parameter to, limit 9999, actual 123456, request ${error.requestId}, server ${host}). ` +
      'Vertices and faces are counted from 0; the last is 9999.',
  );
  assert.equal(String(error), `GeodesicError: ${error.message}`);
});

test('a limit and by how much it was exceeded', async () => {
  const error = await refusal(client.samples(plane, { count: 20000 }));
  assert.match(error.message, /^too_large: .*[^.] \(parameter count, limit 10000, actual 20000, /);
  assert.match(error.message, /\. Asking again will not help: ask for less at once: .*limits.*\.$/);
});

test('the same of a line of a batch, of a stream, and of an upload', async () => {
  for await (const answer of client.batch(plane, [{ query: 'path', from: 0, to: 123456 }])) {
    assert.ok(!answer.ok && answer.error.message.includes(`server ${host}`));
  }
  const unknown = await refusal(client.batch('0'.repeat(64), [{ query: 'samples', count: 1 }]).next());
  assert.ok(unknown.message.includes(`server ${host}`));
  const words = new TextEncoder().encode('this is no mesh');
  for (const options of [{}, { onProgress: () => undefined }]) {
    const error = await refusal(client.upload(words, options));
    assert.match(error.message, new RegExp(`^format_unknown: .*server ${host}\\)\\. three\\.js loads`));
  }
});

test('memory: of the computation, and of the reply', async () => {
  const scant = await Server.start(['--query-memory-bytes', '100KiB']);
  try {
    const there = new GeodesicClient(scant.url);
    const { id } = await there.upload(new Uint8Array(await (await client.source(plane)).arrayBuffer()));
    const { message } = await refusal(there.distance(id, { from: 0, method: 'exact' }));
    assert.match(message, /^too_much_memory: .*--query-memory-bytes\.$/);
  } finally {
    await scant.stop();
  }
  const problem = { code: 'too_much_memory', detail: 'the reply is too long' } as const;
  assert.match(new GeodesicError(413, problem).message, /larger --reply-memory-bytes\.$/);
});

test('a reply that is not of geodesicd names who was asked', async () => {
  const replies: [number, RegExp][] = [
    [502, /does not reach it\. Is it running\?$/],
    [413, /client_max_body_size\.$/],
    [418, /is that address one, and what is between\?$/],
  ];
  for (const [status, hint] of replies) {
    const page = async () => new Response('<html>', { status });
    const behind = new GeodesicClient('http://example.invalid:81/base', { fetch: page, retries: 0 });
    const error = await refusal(behind.status());
    assert.equal(error.code, 'unrecognised');
    assert.match(error.message, /\(server example\.invalid:81\)/);
    assert.match(error.message, hint);
  }
});
