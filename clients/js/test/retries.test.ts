/** Second tries: when, after how long, and when not. Behind a proxy that fails on demand. */
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { GeodesicClient, GeodesicError, NetworkError } from 'geodesicd-client';
import { FaultyProxy, type Fault } from './faulty_proxy.js';
import { fixture, until } from './fixture.js';
import { Server } from './server.js';

const { server, plane } = await fixture();
const proxy = await FaultyProxy.before(server.url);
after(() => proxy.stop());
const client = new GeodesicClient(proxy.url);
const impatient = new GeodesicClient(proxy.url, { maxRetryWait: 1500 });

/** The next requests fail like this; how many were sent in all. */
async function sentWith(faults: Fault[], act: () => Promise<unknown>): Promise<number> {
  proxy.seen.length = 0;
  proxy.faults = faults.map((fault) => ({ on: '/', fault }));
  await act();
  return proxy.seen.length;
}

const busy = (status: number, headers = {}): Fault => ({ status, headers });

test('429, 503 and lost connections are tried again', async () => {
  const faults: Fault[] = [busy(429, { 'Retry-After': '0' }), busy(503), { drop: true }];
  assert.equal(await sentWith(faults, () => client.path(plane, { from: 0, to: 9 })), 4);
});

test('a reply that is cut short is asked for again', async () => {
  const act = async () => {
    assert.equal((await client.distance(plane, { from: 0 })).values.length, 10000);
  };
  assert.equal(await sentWith([{ cutAfter: 5000 }], act), 2);
});

test('a query by POST is tried again too: it changes nothing', async () => {
  const from = { vertex: 0, offset: 1 };
  assert.equal(await sentWith([{ drop: true }], () => client.distance(plane, { from })), 2);
});

test('three times, no more', async () => {
  const faults = Array.from({ length: 9 }, () => busy(503));
  const act = () => assert.rejects(client.status(), { status: 503 });
  assert.equal(await sentWith(faults, act), 4);
  const lost = Array.from({ length: 9 }, (): Fault => ({ drop: true }));
  assert.equal(await sentWith(lost, () => assert.rejects(client.status(), NetworkError)), 4);
  const never = new GeodesicClient(proxy.url, { retries: 0 });
  assert.equal(await sentWith(lost, () => assert.rejects(never.status(), NetworkError)), 1);
});

test('a job is not begun twice', async () => {
  const act = () => assert.rejects(client.job(plane, { query: 'path', from: 0, to: 9 }), NetworkError);
  assert.equal(await sentWith([{ drop: true }], act), 1);
});

test("other errors are the caller's at once", async () => {
  const act = () => assert.rejects(client.mesh('0'.repeat(64)), { code: 'mesh_unknown' });
  assert.equal(await sentWith([], act), 1);
  const page: Fault = { status: 502, headers: { 'Content-Type': 'text/html' }, body: '<h1>Bad' };
  const act502 = () =>
    assert.rejects(client.status(), (error: GeodesicError) => {
      assert.equal(error.status, 502);
      assert.equal(error.code, 'unrecognised');
      return true;
    });
  assert.equal(await sentWith([page], act502), 1);
});

test('Retry-After is waited for, in seconds and as a date', async () => {
  const begun = Date.now();
  await sentWith([busy(503, { 'Retry-After': '1' })], () => client.status());
  assert.ok(Date.now() - begun >= 990);
  const later = new Date(Date.now() + 2000).toUTCString(); // whole seconds
  await sentWith([busy(429, { 'Retry-After': later })], () => client.status());
  assert.ok(Date.now() >= Date.parse(later) - 10);
});

test('a Retry-After that is too long is not waited for', async () => {
  const act = () => assert.rejects(impatient.status(), { status: 503, retryAfter: 3600 });
  assert.equal(await sentWith([busy(503, { 'Retry-After': '3600' })], act), 1);
});

test('an abort ends the wait, and nothing is sent after it', async () => {
  const ended = new AbortController();
  const act = async () => {
    const call = client.status({ signal: ended.signal });
    await until(() => proxy.seen.length === 1, 'the first try');
    ended.abort();
    await assert.rejects(call, { name: 'AbortError' });
  };
  assert.equal(await sentWith([busy(503, { 'Retry-After': '20' })], act), 1);
  const aborted = AbortSignal.abort(new Error('mine'));
  const before = () => assert.rejects(client.status({ signal: aborted }), { message: 'mine' });
  assert.equal(await sentWith([], before), 0);
});

test('a server that is gone and comes back', async () => {
  const first = await Server.start();
  const port = Number(new URL(first.url).port);
  await first.stop();
  const patient = new GeodesicClient(`http://127.0.0.1:${port}`, { retries: 12 });
  const call = patient.status();
  const second = await Server.start([], port);
  after(() => second.stop());
  assert.equal((await call).draining, false);
});

test('a server with too many jobs, once one has ended', async () => {
  const { server: small, plane: id } = await fixture(['--max-jobs', '1']);
  const one = new GeodesicClient(small.url, { retries: 30 });
  const ended = new AbortController();
  const from = Array.from({ length: 400 }, (_, row) => ({ vertex: 25 * row }));
  let begun = false;
  const slow = one.job(
    id,
    { query: 'table', from, method: 'chen_han' },
    { signal: ended.signal, onProgress: () => (begun = true) },
  );
  await until(() => begun, 'the first job');
  const refused: number[] = [];
  const counting = new GeodesicClient(small.url, {
    retries: 30,
    fetch: async (input, init) => {
      const reply = await fetch(input, init);
      if (reply.status === 503) refused.push(Number(reply.headers.get('Retry-After')));
      return reply;
    },
  });
  const quick = counting.job(id, { query: 'path', from: 0, to: 9 });
  await until(() => refused.length > 0, 'a refusal');
  ended.abort();
  await assert.rejects(slow, { name: 'AbortError' });
  assert.equal((await quick).length, 9);
  assert.ok(refused.every((seconds) => seconds >= 1));
});

test('an error has all that the problem document has', async () => {
  const call = client.path(plane, { from: 0, to: 10000 });
  await assert.rejects(call, (error: GeodesicError) => {
    assert.ok(error instanceof GeodesicError && error instanceof Error);
    assert.match(error.message, /^index_out_of_range: .*\(parameter to, /);
    const { status, code, title, detail, parameter, limit, actual, requestId, retryAfter } = error;
    assert.deepEqual(
      { status, code, parameter, limit, actual, retryAfter },
      { status: 422, code: 'index_out_of_range', parameter: 'to', limit: 9999, actual: 10000, retryAfter: undefined },
    );
    return Boolean(title && detail && requestId);
  });
});
