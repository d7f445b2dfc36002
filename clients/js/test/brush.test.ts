/** The example of a brush along the surface, used with a mouse in a real browser. */
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, test } from 'node:test';
import { GeodesicClient } from 'geodesicd-client';
import { noBrowser, openPage } from './browser_page.js';
import { sample, Server } from './server.js';

test('the brush paints what is within its radius', { skip: noBrowser }, async () => {
  const server = await Server.start();
  after(() => server.stop());
  await new GeodesicClient(server.url).upload(sample('plane.glb')); // a vertex a unit of area
  const found = (await openPage('/test/page/brush_page.js', server.url)) as {
    error?: string;
    hovered: number;
    painted: number;
    radius: number;
    beside: number;
    wider: number;
  };
  assert.equal(found.error, undefined);
  assert.equal(found.hovered, 0, 'without a button nothing is painted');
  const disc = Math.PI * found.radius ** 2;
  assert.ok(Math.abs(found.painted - disc) < 0.1 * disc, `${found.painted} of about ${disc}`);
  assert.equal(found.beside, found.painted, 'beside the mesh nothing is painted');
  assert.ok(found.wider > 1.2 * found.painted, `${found.wider} by a wider brush`);
});

test('the example is short', () => {
  const text = readFileSync(new URL('../examples/brush.js', import.meta.url), 'utf8');
  assert.ok(text.trimEnd().split('\n').length < 60);
});

test('where the field is flat its outline divides by no zero', () => {
  const text = readFileSync(new URL('../examples/brush.js', import.meta.url), 'utf8');
  assert.match(text, /\/ max\(fwidth\(vReach\), 1e-6\)/);
});
