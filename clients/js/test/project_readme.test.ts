/** The snippet in the project's README, run as it stands but for the server's address. */
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { fixture } from './fixture.js';

const { server } = await fixture();

test('a web page colours a geometry within ten lines', async (t) => {
  const readme = readFileSync(new URL('../../../README.md', import.meta.url), 'utf8');
  const [, code] = /```js\n(.*?)```/s.exec(readme)!;
  assert.ok(code!.trim().split('\n').length <= 10);
  // Below this package, so that its own name leads to it.
  const folder = fileURLToPath(new URL('project_readme', import.meta.url));
  mkdirSync(folder, { recursive: true });
  t.after(() => rmSync(folder, { recursive: true }));
  const script = join(folder, 'snippet.mjs');
  assert.ok(code!.includes('http://localhost:8080'));
  const asked = code!.replace('http://localhost:8080', server.url);
  const said = `
    const colours = geometry.getAttribute('color');
    const distinct = new Set(Array.from(colours.array).map((c) => c.toFixed(3))).size;
    console.log(colours.count === geometry.getAttribute('position').count, field.values.length === colours.count, distinct > 50);`;
  writeFileSync(script, asked + said);
  const { stdout } = await promisify(execFile)(process.execPath, [script]);
  assert.equal(stdout.trim(), 'true true true');
});
