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
const blocks = [...readme.matchAll(/```js\n(.*?)```/gs)].map(([, text]) => text!);
// What draws is run by a test in a browser.
const [drawing, ...snippets] = [...blocks].sort((a, b) => Number(b.includes('document.')) - Number(a.includes('document.')));

// Below this package, so that its own name leads to it.
const folder = fileURLToPath(new URL('readme_snippets', import.meta.url));
mkdirSync(folder, { recursive: true });
writeFileSync(join(folder, 'mesh.glb'), sample('plane.glb'));
writeFileSync(join(folder, 'several.glb'), twice(sample('plane.glb')));
after(() => rmSync(folder, { recursive: true }));

/** The GLB with a second node for its mesh, so that it has two parts. */
function twice(glb: Uint8Array): Uint8Array {
  const end = 20 + new DataView(glb.buffer).getUint32(12, true);
  const document = JSON.parse(new TextDecoder().decode(glb.subarray(20, end)));
  document.nodes.push({ ...document.nodes[0], name: 'again', translation: [0, 0, 5] });
  document.scenes[0].nodes.push(document.nodes.length - 1);
  const text = JSON.stringify(document);
  const json = new TextEncoder().encode(text.padEnd(Math.ceil(text.length / 4) * 4));
  const made = new Uint8Array(20 + json.length + glb.length - end);
  made.set(glb.subarray(0, 20));
  made.set(json, 20);
  made.set(glb.subarray(end), 20 + json.length);
  const head = new DataView(made.buffer);
  head.setUint32(8, made.length, true);
  head.setUint32(12, json.length, true);
  return made;
}

/** What each prints in the end, in their order. */
const LAST = [
  /^true 140\.007\d*$/,
  /^true 4(\.0+\d*)? \d+ \{/,
  /^3 50$/,
  /^123456 index_out_of_range$/,
  /^2 10000$/,
  /^true 0\.14142135\d*$/,
  /^2 0,10000$/,
  /^113 226 0\.5$/,
];

test('the README has a snippet for each expectation', () => {
  assert.equal(snippets.length, LAST.length);
});

test('the finished example is the file', () => {
  const file = readFileSync(new URL('../examples/field.js', import.meta.url), 'utf8');
  assert.equal(drawing, file);
  assert.ok(file.split('\n').length < 36, 'and it is short');
});

test('the tarball of the steps is the one that npm makes', () => {
  const { version } = JSON.parse(readFileSync(new URL('../package.json', import.meta.url), 'utf8')) as { version: string };
  assert.ok(readme.includes(`geodesicd-client-${version}.tgz`));
  assert.doesNotMatch(readme, /npm install geodesicd-client\b(?!-)/, 'it is in no registry');
});

test('each call beside a picture is answered', async () => {
  const calls = [...readme.matchAll(/^\| \[<img .*\| `(.+)` \|$/gm)].map(([, call]) => call!);
  assert.ok(calls.length >= 14);
  const { id } = await client.upload(sample('plane_three_holes.glb'));
  for (const call of calls) {
    const asked = new Function('client', 'id', `return ${call}`) as (on: typeof client, id: string) => Promise<unknown>;
    assert.ok(await asked(client, id), call);
  }
  await client.deleteMesh(id);
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
