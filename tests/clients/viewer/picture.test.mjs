// The README's picture of the viewer can be drawn anew.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { drawViewer } from '../../../scripts/draw_viewer.mjs';
import { statistics } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();

test('scripts/draw_viewer draws a picture like the one that is kept', async () => {
  const kept = await readFile(new URL('../../../docs/viewer.png', import.meta.url));
  const [drawn, there] = [await drawViewer(browser, service), kept].map(statistics);
  assert.deepEqual([drawn.width, drawn.height], [there.width, there.height]);
  assert.ok(drawn.colourful > 0.15, 'the field is seen');
  assert.ok(Math.abs(drawn.colourful - there.colourful) < 0.1, 'as much of it as in the one that is kept');
});
