// The pixels that the other tests count are those that a browser sees in the same picture.
import assert from 'node:assert/strict';
import { randomInt } from 'node:crypto';
import { after, test } from 'node:test';
import { deflateSync } from 'node:zlib';
import { launch, newPage } from './browser.mjs';
import { boxOfWhatIsDrawn, difference, shareOf, statistics } from './pixels.mjs';
import { decodePng } from './png.mjs';

const browser = await launch();
after(() => browser.close());

/** A PNG in RGB whose rows are predicted in each of the five ways, by turns: any bytes are right ones. */
function anyPng(width, height, next) {
  const rows = Buffer.from(Array.from({ length: height * (3 * width + 1) }, (_, at) =>
    at % (3 * width + 1) ? Math.floor(256 * next()) : Math.floor(at / (3 * width + 1)) % 5));
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2], 8);
  const packed = deflateSync(rows);
  const parts = [['IHDR', header], ['IDAT', packed.subarray(0, 1000)], ['IDAT', packed.subarray(1000)], ['IEND', Buffer.alloc(0)]];
  return Buffer.concat([Buffer.from('89504e470d0a1a0a', 'hex'), ...parts.flatMap(([type, data]) => chunk(type, data))]);
}

function chunk(type, data) {
  const [size, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
  size.writeUInt32BE(data.length);
  const named = Buffer.concat([Buffer.from(type), data]);
  let crc = 0xffffffff;
  for (const byte of named) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  sum.writeUInt32BE(~crc >>> 0);
  return [size, named, sum];
}

/** What a page sees in a PNG: RGBA. */
async function seenIn(page, png) {
  return Buffer.from(await page.evaluate(async (bytes) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(bytes)], { type: 'image/png' }));
    const sheet = new OffscreenCanvas(image.width, image.height).getContext('2d');
    sheet.drawImage(image, 0, 0);
    return [...sheet.getImageData(0, 0, image.width, image.height).data];
  }, [...png]));
}

test('a PNG has the pixels that a browser sees in it, however its rows are predicted', async () => {
  const seed = Number(process.env.GEODESICD_SEED || randomInt(1, 2147483647));
  console.log(`GEODESICD_SEED=${seed}`);
  let state = seed;
  const png = anyPng(113, 60, () => (state = (state * 48271) % 2147483647) / 2147483647);
  const page = await newPage(browser);
  const { width, height, data } = decodePng(png);
  assert.deepEqual([width, height], [113, 60]);
  assert.ok((await seenIn(page, png)).equals(Buffer.from(data)));
  // With transparency, as pictures of a canvas are: nothing, something, everything.
  const glass = Buffer.from(await page.evaluate(async () => {
    const canvas = new OffscreenCanvas(50, 40);
    const sheet = canvas.getContext('2d');
    sheet.fillStyle = '#e8835a';
    sheet.fillRect(10, 10, 20, 20);
    sheet.fillStyle = '#4f8fd080';
    sheet.fillRect(20, 20, 30, 20);
    return [...new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer())];
  }));
  assert.ok((await seenIn(page, glass)).equals(Buffer.from(decodePng(glass).data)));
  assert.deepEqual([...decodePng(glass).data.subarray(0, 4)], [0, 0, 0, 0]);
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
