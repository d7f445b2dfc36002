// What is sent to a browser: how much, and that it runs under the server's policy and
// needs no other host.
import assert from 'node:assert/strict';
import { readdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';

const dist = process.env.VIEWER_DIST;

async function files(folder) {
  const found = await readdir(folder, { withFileTypes: true });
  const all = await Promise.all(
    found.map((entry) => (entry.isDirectory() ? files(join(folder, entry.name)) : [join(folder, entry.name)])),
  );
  return all.flat();
}

test('the bundle is below 400 kB gzipped', async () => {
  let bytes = 0;
  for (const file of await files(dist)) bytes += gzipSync(await readFile(file), { level: 9 }).length;
  console.log(`bundle: ${(bytes / 1000).toFixed(1)} kB gzipped`);
  assert.ok(bytes < 400_000, `${bytes} bytes`);
  assert.ok(bytes > 50_000, 'there is a bundle at all');
});

test('the page has nothing inline and names no host', async () => {
  const page = await readFile(join(dist, 'index.html'), 'utf8');
  assert.doesNotMatch(page, /<style|\sstyle=|\son[a-z]+=|javascript:/i);
  for (const [, attributes, content] of page.matchAll(/<script([^>]*)>([^]*?)<\/script>/g)) {
    assert.match(attributes, /\ssrc="\.\/assets\//);
    assert.equal(content.trim(), '');
  }
  // Nor the root of one: the page works under any path.
  assert.doesNotMatch(page, /(src|href)="(https?:|\/)/);
  for (const file of await files(dist)) {
    if (file.endsWith('.css')) assert.doesNotMatch(await readFile(file, 'utf8'), /url\(['"]?(https?:|\/)/, file);
  }
  const names = (await files(dist)).map((file) => file.slice(dist.length + 1));
  for (const name of names) assert.match(name, /^(index\.html|assets\/[\w.-]+-[\w-]{8}\.\w+)$/);
});
