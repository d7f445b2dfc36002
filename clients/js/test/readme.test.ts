/** The README's snippets, each run as it stands but for the server's address. */
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { fixture } from './fixture.js';
import { sample } from './server.js';

const { server, client, plane } = await fixture();
await client.deleteMesh(plane); // the first snippet uploads it

const readme = readFileSync(new URL('../README.md', import.meta.url), 'utf8');
const snippets = [...readme.matchAll(/```js\n(.*?)```/gs)].map(([, text]) => text!);

// Below this package, so that its own name leads to it.
const folder = fileURLToPath(new URL('readme_snippets', import.meta.url));
mkdirSync(folder, { recursive: true });
writeFileSync(join(folder, 'mesh.glb'), sample('plane.glb'));
after(() => rmSync(folder, { recursive: true }));

/** What each prints in the end, in their order. */
const LAST = [
  /^true 140\.007\d*$/,
  /^true 4(\.0+\d*)? \d+ \{/,
  /^3 50$/,
  /^123456 index_out_of_range$/,
  /^2 10000$/,
];

test('the README has a snippet for each expectation', () => {
  assert.equal(snippets.length, LAST.length);
});

snippets.forEach((snippet, index) => {
  test(`snippet ${index + 1}`, async () => {
    const file = join(folder, `${index + 1}.mjs`);
    assert.ok(snippet.includes('http://localhost:8080'));
    writeFileSync(file, snippet.replace('http://localhost:8080', server.url));
    const { stdout, stderr } = await promisify(execFile)(process.execPath, [file], { cwd: folder });
    assert.equal(stderr, '');
    const last = stdout.trim().split('\n').findLast((line) => /^\S/.test(line) && line !== '}');
    assert.match(last ?? '', LAST[index]!);
  });
});
