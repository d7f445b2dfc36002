// The README's picture of the viewer, and those of its page, can be drawn anew.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { drawBrush, drawLoop, drawViewer } from '../../../scripts/draw_viewer.mjs';
import { statistics } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();

for (const [name, draw, colourful] of [['viewer', drawViewer, 0.15], ['viewer_brush', drawBrush, 0.15], ['viewer_loop', drawLoop, 0]]) {
  test(`scripts/draw_viewer draws ${name}.png like the one that is kept`, async () => {
    const kept = await readFile(new URL(`../../../docs/${name}.png`, import.meta.url));
    const [drawn, there] = [await draw(browser, service), kept].map(statistics);
    assert.deepEqual([drawn.width, drawn.height], [there.width, there.height]);
    assert.ok(drawn.colourful > colourful, 'the field, or the line, is seen');
    assert.ok(Math.abs(drawn.colourful - there.colourful) < 0.1, 'as much of it as in the one that is kept');
  });
}
