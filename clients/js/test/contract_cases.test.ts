/**
 * Runs the shared table of contract cases, tests/clients/contract_cases.json, through this
 * client. The table's `about` has the format in full; in short, a row is a call by its
 * endpoint's name with the contract's arguments on a mesh of one of the table's servers,
 * and what is to come of it: a status, an error's code and parameter, members of the JSON
 * by path, arrays with type, shape and values, bytes, headers. A row may have `steps`
 * instead, whose saved values stand in later ones as `{name}`. case_calls.ts says which
 * method of this client a row takes, case_checks.ts how the two are compared.
 */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { GeodesicClient, GeodesicError } from 'geodesicd-client';
import { carryOut, type Outcome } from './case_calls.js';
import { checkError, checkOutcome, memberAt } from './case_checks.js';
import { readCases, type Arguments, type Case, type Step } from './case_table.js';
import { sample, Server } from './server.js';

const table = readCases();
const servers = new Map<string, Promise<Server>>();
const folder = mkdtempSync(join(tmpdir(), 'js_cases_'));

after(async () => {
  await Promise.all([...servers.values()].map(async (server) => (await server).stop()));
  rmSync(folder, { recursive: true });
});

function serverOf(name: string): Promise<Server> {
  const { flags, tokens } = table.servers[name]!;
  if (!servers.has(name)) {
    const all = [...flags];
    if (tokens) {
      const lines = Object.entries(tokens).map(([who, [token, scopes]]) => {
        return `${who} ${scopes} ${createHash('sha256').update(token).digest('hex')}\n`;
      });
      writeFileSync(join(folder, name), lines.join(''), { mode: 0o600 });
      all.push('--tokens', join(folder, name));
    }
    servers.set(name, Server.start(all));
  }
  return servers.get(name)!;
}

function clientFor(url: string, server: string, who: string | null): GeodesicClient {
  const token = who === null ? undefined : table.servers[server]?.tokens?.[who]?.[0];
  return new GeodesicClient(url, { retries: 0, ...(token && { token }) });
}

function dataOf(name: string): Uint8Array {
  const inline = table.meshes[name];
  return inline ? new TextEncoder().encode(inline.text) : sample(name);
}

function filledIn<T>(value: T, saved: Record<string, string>): T {
  let text = JSON.stringify(value);
  for (const [name, what] of Object.entries(saved)) {
    text = text.replaceAll(`{${name}}`, JSON.stringify(what).slice(1, -1));
  }
  return JSON.parse(text) as T;
}

async function runStep(
  client: GeodesicClient,
  id: string,
  step: Step,
  data: Uint8Array | undefined,
  tolerance: number,
): Promise<Outcome> {
  let outcome: Outcome;
  try {
    const given: Arguments = { ...step.arguments };
    // The client's own method cuts what is too large a table.
    if (step.call === 'table' && step.expect.code === 'too_large') given['format'] ??= 'frame';
    outcome = await carryOut(client, id, step.call, given, step.job ?? false, data);
  } catch (error) {
    if (!(error instanceof GeodesicError) || step.expect.status < 400) throw error;
    checkError(error, step.expect);
    return {};
  }
  assert.ok(step.expect.status < 400, `a success instead of ${step.expect.code}`);
  checkOutcome(outcome, step.expect, tolerance);
  return outcome;
}

async function runCase(row: Case): Promise<void> {
  const name = row.server ?? 'plain';
  const { url } = await serverOf(name);
  const client = clientFor(url, name, row.token === undefined ? 'admin' : row.token);
  const data = typeof row.mesh === 'string' ? dataOf(row.mesh) : undefined;
  const given = typeof row.mesh === 'object' ? row.mesh.id : '';
  let id = given;
  if (data && row.call !== 'upload') id = (await clientFor(url, name, 'admin').upload(data)).id;
  const saved: Record<string, string> = {};
  for (const step of row.steps ?? [row as Step]) {
    const outcome = await runStep(client, id, filledIn(step, saved), data, row.tolerance ?? 1e-9);
    for (const [key, { header, json }] of Object.entries(step.save ?? {})) {
      const value = header ? outcome.headers?.get(header) : memberAt(outcome.json, json ?? '');
      assert.equal(typeof value, 'string', `nothing to save as ${key}`);
      saved[key] = value as string;
    }
  }
}

for (const row of table.cases) test(row.name, () => runCase(row));

test('every error code of the contract is in the table, or why it cannot be', async () => {
  const { url } = await serverOf('plain');
  const reply = await new GeodesicClient(url).request({ method: 'GET', path: '/openapi.json' });
  const contract = JSON.parse(new TextDecoder().decode(reply.body));
  const codes: string[] = contract.components.schemas.ErrorCode.enum;
  const text = JSON.stringify(table.cases);
  for (const code of codes) {
    const there = text.includes(`"code":"${code}"`);
    assert.notEqual(there, code in table.not_here, `${code} is in both or in neither`);
  }
});

test('every operation of the contract is in the table', async () => {
  const { url } = await serverOf('plain');
  const reply = await new GeodesicClient(url).request({ method: 'GET', path: '/openapi.json' });
  const contract = JSON.parse(new TextDecoder().decode(reply.body));
  const steps = table.cases.flatMap((row) => row.steps ?? [row as Step]);
  const calls = new Set(steps.map((one) => one.call));
  const asked = steps
    .filter((one) => one.call === 'request')
    .map((one) => String(one.arguments?.['path']).replace(/[?].*/, ''));
  for (const path of Object.keys(contract.paths)) {
    if (path === '/v1/jobs/{job}/events') continue; // every row with `job` goes by it
    const last = path.split('/').at(-1)!;
    const named = path === '/v1/meshes' ? 'list' : path === '/v1/meshes/{id}' ? 'mesh' : last;
    assert.ok(calls.has(named) || asked.includes(path), `${path} is in no row`);
  }
});
