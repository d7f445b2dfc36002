/** Batches: answers as they arrive, an end whenever the reader has enough. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type BatchQuery, GeodesicError } from 'geodesicd-client';
import { fixture, SLOW, until } from './fixture.js';
import { sample } from './server.js';

const { client, plane } = await fixture(['--compute-threads', '1']);
const terrain = (await client.upload(sample('terrain.glb'))).id;

const quickThenSlow: BatchQuery[] = [
  { id: 'quick', query: 'path', from: 0, to: 9 },
  { id: 'slow', query: 'table', ...SLOW },
];

async function idle(): Promise<boolean> {
  return (await client.status()).compute.running === 0;
}

test('an answer is there before the next is computed; who leaves ends the rest', async () => {
  for await (const answer of client.batch(terrain, quickThenSlow)) {
    assert.equal(answer.id, 'quick');
    assert.ok(answer.ok);
    break;
  }
  await until(idle, 'the server to stop computing');
});

test('an abort ends a batch under way', async () => {
  const ended = new AbortController();
  const read = async () => {
    for await (const answer of client.batch(terrain, quickThenSlow, { signal: ended.signal })) {
      assert.equal(answer.id, 'quick');
      ended.abort();
    }
  };
  await assert.rejects(read(), { name: 'AbortError' });
  await until(idle, 'the server to stop computing');
});

test('a thousand paths in one request, in their order', async () => {
  const asked = Array.from({ length: 1000 }, (_, to) => ({ id: to, query: 'path' as const, from: 0, to }));
  let next = 0;
  for await (const answer of client.batch(plane, asked)) {
    assert.equal(answer.id, next++);
    assert.ok(answer.ok && answer.reply.reachable);
    if (answer.ok && next <= 100) assert.equal(answer.reply.length, next - 1);
  }
  assert.equal(next, 1000);
});

test('one that fails harms no other', async () => {
  const asked = [
    { query: 'path' as const, from: 0, to: 10000 },
    { query: 'path' as const, from: { xyz: [0, 0, 5] as const, max_snap: 1 }, to: 1 },
    { query: 'path' as const, from: 0, to: 1 },
  ];
  const answers = [];
  for await (const answer of client.batch(plane, asked)) answers.push(answer);
  const codes = answers.map((answer) => (answer.ok ? 'ok' : answer.error.code));
  assert.deepEqual(codes, ['index_out_of_range', 'snap_too_far', 'ok']);
  assert.ok(!answers[0]!.ok && answers[0]!.error instanceof GeodesicError);
});

test('no queries, no answers', async () => {
  for await (const answer of client.batch(plane, [])) assert.fail(String(answer.status));
});
