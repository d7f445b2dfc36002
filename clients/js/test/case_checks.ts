/** Comparing what came of a call with what its row in the table expects. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { GeodesicError } from 'geodesicd-client';
import type { Outcome, OutcomeArray } from './case_calls.js';
import type { ArrayExpected, Expected } from './case_table.js';

export function checkError(error: GeodesicError, expected: Expected): void {
  assert.equal(error.status, expected.status);
  assert.equal(error.code, expected.code);
  if (expected.parameter !== undefined) {
    const allowed = [expected.parameter].flat();
    assert.ok(allowed.includes(error.parameter ?? ''), `${error.parameter} is none of ${allowed}`);
  }
  if (expected.limit !== undefined) assert.equal(error.limit, expected.limit);
  if (expected.actual !== undefined) assert.equal(error.actual, expected.actual);
  if (expected.retry_after) assert.ok((error.retryAfter ?? 0) > 0, 'no Retry-After');
  assert.ok(error.title && error.detail && error.requestId, 'an error without its words');
}

export function checkOutcome(outcome: Outcome, expected: Expected, tolerance: number): void {
  if (outcome.status !== undefined) assert.equal(outcome.status, expected.status);
  for (const [path, value] of Object.entries(expected.json ?? {})) {
    checkValue(memberAt(outcome.json, path), value, tolerance, path);
  }
  for (const [name, array] of Object.entries(expected.arrays ?? {})) {
    const found = outcome.arrays?.[name];
    assert.ok(found, `no array ${name}`);
    checkArray(found, array, tolerance, name);
  }
  if (expected.bytes) checkBytes(outcome, expected.bytes);
  for (const [name, pattern] of Object.entries(expected.headers ?? {})) {
    assert.match(outcome.headers?.get(name) ?? '', new RegExp(pattern), name);
  }
  if (expected.lines) checkLines(outcome.lines ?? [], expected.lines, tolerance);
}

/** The member of a reply that a path such as `points[0].xyz` names. */
export function memberAt(value: unknown, path: string): unknown {
  return path
    .split(/[.[\]]+/)
    .filter(Boolean)
    .reduce<unknown>((part, name) => (part as Record<string, unknown> | null)?.[name], value);
}

function isNear(found: unknown, wanted: number, tolerance: number): boolean {
  const slack = tolerance * Math.max(1, Math.abs(wanted));
  return typeof found === 'number' && Math.abs(found - wanted) <= slack;
}

function checkValue(found: unknown, wanted: unknown, tolerance: number, path: string): void {
  if (typeof wanted === 'number') {
    assert.ok(isNear(found, wanted, tolerance), `${path} is ${found}, not ${wanted}`);
  } else if (Array.isArray(wanted)) {
    assert.ok(Array.isArray(found) && found.length === wanted.length, `${path} is ${found}`);
    wanted.forEach((one, i) => checkValue(found[i], one, tolerance, `${path}[${i}]`));
  } else if (typeof wanted === 'object' && wanted !== null) {
    checkRule(found, wanted as Record<string, unknown>, path);
  } else {
    assert.equal(found, wanted, path);
  }
}

function checkRule(found: unknown, rule: Record<string, unknown>, path: string): void {
  const [name] = Object.keys(rule);
  switch (name) {
    case 'count':
      assert.ok(Array.isArray(found), `${path} is no list`);
      return assert.equal(found.length, rule['count'], `the length of ${path}`);
    case 'between': {
      const [low, high] = rule['between'] as [number, number];
      const inside = typeof found === 'number' && found >= low && found <= high;
      return assert.ok(inside, `${path} is ${found}, not from ${low} to ${high}`);
    }
    case 'matches':
      return assert.match(String(found), new RegExp(rule['matches'] as string), path);
    case 'absent':
      // The client's lists are always there; an empty one says as much.
      if (Array.isArray(found)) return assert.deepEqual(found, [], path);
      return assert.equal(found, undefined, path);
    default:
      throw new Error(`the table has a rule that is not known: ${name}`);
  }
}

function checkArray(
  found: OutcomeArray,
  wanted: ArrayExpected,
  tolerance: number,
  name: string,
): void {
  assert.equal(found.dtype, wanted.dtype, `the type of ${name}`);
  assert.deepEqual(found.shape, wanted.shape, `the shape of ${name}`);
  const count = wanted.shape.reduce((product, side) => product * side, 1);
  assert.equal(found.data.length, count, `the length of ${name}`);
  for (const [index, value] of Object.entries(wanted.values)) {
    // What passes through float32 has seven digits.
    const allowed = wanted.dtype === '<f4' ? Math.max(tolerance, 1e-6) : tolerance;
    checkValue(found.data[Number(index)], value, allowed, `${name}[${index}]`);
  }
  const nowhere: Record<string, number> = { '<u4': 0xffffffff, '<u2': 65535 };
  for (const index of wanted.unreached ?? []) {
    assert.equal(found.data[index], nowhere[wanted.dtype] ?? Infinity, `${name}[${index}]`);
  }
  if (wanted.max !== undefined) checkValue(found.max, wanted.max, tolerance, `max of ${name}`);
}

function checkBytes({ bytes }: Outcome, wanted: NonNullable<Expected['bytes']>): void {
  assert.ok(bytes, 'no bytes');
  const { data, type } = bytes;
  const text = (start: number, end: number) => new TextDecoder().decode(data.subarray(start, end));
  if (wanted.begins) assert.equal(text(0, wanted.begins.length), wanted.begins);
  if (wanted.at_least) assert.ok(data.length >= wanted.at_least, `only ${data.length} bytes`);
  if (wanted.media_type && type !== undefined) assert.equal(type, wanted.media_type);
  if (wanted.sha256) {
    assert.equal(createHash('sha256').update(data).digest('hex'), wanted.sha256);
  }
  if (wanted.png) {
    assert.equal(text(1, 4), 'PNG');
    const head = new DataView(data.buffer, data.byteOffset);
    assert.deepEqual([head.getUint32(16), head.getUint32(20)], wanted.png);
  }
}

interface Line {
  id?: unknown;
  status: number;
  reply?: unknown;
  error?: GeodesicError;
}

function checkLines(found: unknown[], wanted: Expected[], tolerance: number): void {
  assert.equal(found.length, wanted.length, 'answers');
  wanted.forEach((expected, i) => {
    const line = found[i] as Line;
    assert.equal(line.id, expected.id);
    assert.equal(line.status, expected.status);
    if (expected.code) return checkError(line.error as GeodesicError, expected);
    checkOutcome({ json: line.reply }, { ...expected, status: 200 }, tolerance);
  });
}
