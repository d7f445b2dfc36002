// The pixels that the other tests count are those that a browser sees in the same picture.
import assert from 'node:assert/strict';
import { randomInt } from 'node:crypto';
import { after, test } from 'node:test';
import { launch, newPage } from './browser.mjs';
import { boxOfWhatIsDrawn, difference, shareOf, statistics } from './pixels.mjs';
import { decodePng } from './png.mjs';

const browser = await launch();
after(() => browser.close());

/** Draws in a page: noise, which a PNG keeps as it is, ramps and flat rectangles, which it predicts; its PNG and pixels. */
async function drawn(page, alpha, seed) {
  const [png, pixels] = await page.evaluate(async ([opaque, first]) => {
    let state = first;
    const next = () => (state = (state * 48271) % 2147483647) / 2147483647;
    const canvas = new OffscreenCanvas(211, 97);
    const sheet = canvas.getContext('2d', { alpha: !opaque });
    const ramp = sheet.createLinearGradient(0, 0, 211, 97);
    for (const at of [0, 0.3, 1]) ramp.addColorStop(at, `hsl(${360 * next()} 80% 50%)`);
    sheet.fillStyle = ramp;
    sheet.fillRect(0, 0, 211, 97);
    for (let i = 0; i < 2000; i++) {
      sheet.fillStyle = `rgb(${256 * next()} ${256 * next()} ${256 * next()})`;
      const size = i < 20 ? 40 : 1;
      sheet.fillRect(Math.floor(211 * next()), Math.floor(97 * next()), size, size);
    }
    const bytes = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
    return [[...bytes], [...sheet.getImageData(0, 0, 211, 97).data]];
  }, [!alpha, seed]);
  return { png: Buffer.from(png), pixels };
}

test('a PNG with and without transparency has the pixels that were drawn', async () => {
  const seed = Number(process.env.GEODESICD_SEED || randomInt(1, 2147483647));
  console.log(`GEODESICD_SEED=${seed}`);
  const page = await newPage(browser);
  for (const alpha of [true, false]) {
    const { png, pixels } = await drawn(page, alpha, seed);
    const decoded = decodePng(png);
    assert.deepEqual([decoded.width, decoded.height], [211, 97]);
    assert.ok(Buffer.from(pixels).equals(Buffer.from(decoded.data)), `alpha ${alpha}`);
  }
  await page.context().close();
});

test('a picture of a page is measured as it was drawn', async () => {
  const page = await newPage(browser, { viewport: { width: 200, height: 100 } });
  const seen = async (left) => {
    await page.setContent(`<body style="margin: 0; background: #102030"><div style="position: absolute; left: ${left}px; top: 30px; width: 50px; height: 40px; background: #e8835a"></div>`);
    return page.screenshot();
  };
  const [one, other] = [await seen(20), await seen(30)];
  assert.equal(shareOf(one, '#e8835a'), 0.1);
  assert.deepEqual(boxOfWhatIsDrawn(one), { left: 20, top: 30, right: 70, bottom: 70 });
  assert.deepEqual(boxOfWhatIsDrawn(one, { top: 50, right: 40 }), { left: 20, top: 50, right: 40, bottom: 70 });
  assert.equal(difference(one, one), 0);
  assert.equal(difference(one, other), 800 / 20_000);
  assert.deepEqual(statistics(one), { width: 200, height: 100, colourful: 0.1, colours: 2, still: 0.9 });
  await page.context().close();
});
