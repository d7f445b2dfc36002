/** Jobs: watched to their end, cancelled by the signal, and followed over lost connections. */
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { GeodesicClient, type Job } from 'geodesicd-client';
import { FaultyProxy } from './faulty_proxy.js';
import { fixture, SLOW, until } from './fixture.js';
import { sample } from './server.js';

const { server, client, plane } = await fixture();
const proxy = await FaultyProxy.before(server.url);
after(() => proxy.stop());
const through = new GeodesicClient(proxy.url);
const terrain = (await client.upload(sample('terrain.glb'))).id;

const TABLE = { query: 'table', from: [0, 50, 5000, 9999], method: 'exact' } as const;

async function jobStatus(id: string): Promise<Job> {
  const { body } = await client.request({ method: 'GET', path: `/v1/jobs/${id}` });
  return JSON.parse(new TextDecoder().decode(body)) as Job;
}

test('a job gives what the plain call gives, and its progress never falls', async () => {
  const told: Job[] = [];
  const asJob = await client.job(plane, TABLE, { onProgress: (job) => told.push(job) });
  const { query: _, ...parameters } = TABLE;
  const plain = await client.table(plane, parameters);
  assert.deepEqual(asJob.distances, plain.distances);
  assert.deepEqual(asJob.rows, plain.rows);
  const progress = told.map((job) => job.progress);
  assert.deepEqual(progress, [...progress].sort((a, b) => a - b));
  assert.equal(told.at(-1)!.state, 'done');
  assert.equal(progress.at(-1), 1);
});

test('a job that is over is forgotten, result and all', async () => {
  let id = '';
  await client.job(plane, { query: 'path', from: 0, to: 9 }, { onProgress: (job) => (id = job.id) });
  const gone = () =>
    jobStatus(id).then(
      () => false,
      (error) => error.code === 'job_unknown',
    );
  await until(gone, 'the job to be forgotten');
});

test('pictures, GLBs, fields and preparations as jobs', async () => {
  const picture = await client.job(plane, { query: 'picture', of: 'distance', from: 0, width: 64, height: 64 });
  assert.equal(picture.type, 'image/png');
  const glb = await client.job(plane, { query: 'glb', of: 'path', from: 0, to: 9 });
  assert.equal(new TextDecoder().decode(new Uint8Array(glb, 0, 4)), 'glTF');
  const field = await client.job(plane, { query: 'distance', from: 3 });
  assert.ok(field.values instanceof Float32Array && field.values[3] === 0);
  assert.equal((await client.job(plane, { query: 'prepare' })).prepared, true);
});

test('an abort cancels the job on the server', async () => {
  const ended = new AbortController();
  let id = '';
  let last = '';
  const job = client.job(
    terrain,
    { query: 'table', ...SLOW },
    { signal: ended.signal, onProgress: (now) => { id = now.id; last = now.state; } },
  );
  await until(() => id !== '', 'the job');
  assert.match((await jobStatus(id)).state, /queued|running/);
  ended.abort(new Error('no longer wanted'));
  await assert.rejects(job, { message: 'no longer wanted' });
  assert.equal(last, 'cancelled', 'and that is told');
  assert.equal((await jobStatus(id)).state, 'cancelled');
});

test('a job that somebody else cancels', async () => {
  let id = '';
  const job = client.job(
    terrain,
    { query: 'table', ...SLOW },
    { onProgress: (now) => (id = now.id) },
  );
  const rejected = assert.rejects(job, { status: 409, code: 'job_cancelled' });
  await until(() => id !== '', 'the job');
  await client.request({ method: 'DELETE', path: `/v1/jobs/${id}` });
  await rejected;
});

test('an error is that of the query', async () => {
  const job = client.job(plane, { query: 'path', from: 0, to: 10000 });
  await assert.rejects(job, { code: 'index_out_of_range', parameter: 'to', actual: 10000 });
  const late = client.job(terrain, { query: 'table', ...SLOW }, { deadlineMs: 1 });
  await assert.rejects(late, { status: 504, code: 'deadline' });
});

test('a stream of events that breaks is taken up again', async () => {
  proxy.seen.length = 0;
  proxy.faults = [
    { on: '/events', fault: { drop: true } },
    { on: '/events', fault: { cutAfter: 30 } },
    { on: '/result', fault: { drop: true } },
  ];
  const table = await through.job(plane, { ...TABLE, from: [1, 51, 5001, 9998] });
  assert.equal(table.distances.length, 16);
  const asked = (what: string) => proxy.seen.filter((one) => one.endsWith(what)).length;
  assert.ok(asked('/events') >= 2);
  assert.equal(asked('/result'), 2);
});

test('nothing is begun for a signal that was aborted before', async () => {
  proxy.seen.length = 0;
  const signal = AbortSignal.abort();
  await assert.rejects(through.job(plane, TABLE, { signal }), { name: 'AbortError' });
  assert.deepEqual(proxy.seen, []);
});

test("what onProgress throws is the caller's, and the job is cancelled", async () => {
  let id = '';
  const job = client.job(
    terrain,
    { query: 'table', ...SLOW },
    {
      onProgress(now) {
        id = now.id;
        throw new Error('of the page');
      },
    },
  );
  await assert.rejects(job, { message: 'of the page' });
  const over = async () => !/queued|running/.test((await jobStatus(id)).state);
  await until(over, 'the job to end');
});
