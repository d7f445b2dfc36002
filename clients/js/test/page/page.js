/**
 * What a page of another origin does with the client. Its findings go back to the test
 * that served it. The address of the server is in the page's own.
 */
import { GeodesicClient, GeodesicError, NetworkError } from '/dist/index.js';

const client = new GeodesicClient(new URLSearchParams(location.search).get('server'));
const found = {};
try {
  const bytes = await (await fetch('/mesh.glb')).blob();
  const sent = [];
  const mesh = await client.upload(bytes, { onProgress: (...report) => sent.push(report) });
  found.sent = sent.at(-1);
  found.digestFirst = (await client.upload(bytes)).id === mesh.id;

  const field = await client.distance(mesh.id, { from: 0 });
  found.field = [field.values.length, field.values[99], field.cache, field.timing.solve > 0];
  const bare = await client.array(mesh.id, { of: 'distance', from: 0, format: 'f32' });
  found.bare = [bare.dtype, bare.shape, bare.max === field.max];

  const states = [];
  const ask = { query: 'table', from: [0, 99], method: 'exact' };
  const table = await client.job(mesh.id, ask, { onProgress: (job) => states.push(job.state) });
  found.job = [table.distances[1], states.at(-1)];
  const cancel = new AbortController();
  const from = Array.from({ length: 900 }, (_, row) => row * 11);
  let id;
  const slow = client.job(
    mesh.id,
    { query: 'table', from, method: 'chen_han' },
    {
      signal: cancel.signal,
      onProgress(job) {
        id = job.id;
        cancel.abort();
      },
    },
  );
  found.abort = await slow.catch((error) => error.name);
  const { body } = await client.request({ method: 'GET', path: `/v1/jobs/${id}` });
  found.cancelled = JSON.parse(new TextDecoder().decode(body)).state;

  found.batch = [];
  const paths = [9, 123456].map((to) => ({ query: 'path', from: 0, to }));
  for await (const answer of client.batch(mesh.id, paths)) {
    found.batch.push(answer.ok ? answer.reply.length : answer.error.code);
  }
  const refused = await client.upload(new Blob(['x']), { onProgress() {} }).catch((error) => error);
  found.refused = refused instanceof GeodesicError && [refused.code, Boolean(refused.requestId)];
  const nobody = new GeodesicClient('http://127.0.0.1:9', { retries: 0 });
  found.nobody = await nobody.status().catch((error) => error instanceof NetworkError);
} catch (error) {
  found.failed = `${error}\n${error.stack}`;
}
await fetch('/found', { method: 'POST', body: JSON.stringify(found) });
