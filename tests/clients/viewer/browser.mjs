// Debian's Chromium with WebGL in software, pages that note what goes wrong in them, and
// what a picture shows in numbers: shares of coloured pixels, distinct colours, how much
// two pictures differ.
import { createRequire } from 'node:module';
import { join } from 'node:path';

const { CHROMIUM, VIEWER_PICTURES, VIEWER_SOURCES } = process.env;
const require = createRequire(join(VIEWER_SOURCES, 'package.json'));
const { chromium } = require('playwright-core');
export const axe = require.resolve('axe-core/axe.min.js');

export const PATIENCE = Number(process.env.VIEWER_PATIENCE ?? 120_000); // milliseconds; machines are loaded
export const WIDE = { width: 1200, height: 760 };

export async function launch() {
  return chromium.launch({
    executablePath: CHROMIUM,
    args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--disable-dev-shm-usage'],
  });
}

/** A page in a context of its own; `page.faults` are its errors, `page.asked` the targets it asked for. */
export async function newPage(browser, options = {}) {
  const context = await browser.newContext({ viewport: WIDE, acceptDownloads: true, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.faults = [];
  page.asked = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type())) page.faults.push(message.text());
  });
  page.on('pageerror', (error) => page.faults.push(error.stack));
  page.on('request', (request) => page.asked.push(request.url()));
  return page;
}

export async function ready(page, state = 'ready') {
  await page.waitForSelector(`body[data-state="${state}"]`);
}

/** Asks `condition` until its answer is true-like, and gives that. From outside: the page's policy allows no eval. */
export async function until(condition, what) {
  const end = Date.now() + PATIENCE;
  for (;;) {
    const answer = await condition();
    if (answer) return answer;
    if (Date.now() > end) throw new Error(`never came: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/** The text at a selector once it fulfils a condition. */
export function textAt(page, selector, fits) {
  return until(async () => {
    const text = await page.locator(selector).textContent();
    return fits(text) && text;
  }, `text at ${selector}`);
}

/** The length of the path as the panel says it, other than `before`. */
export function pathLength(page, before = '') {
  return textAt(page, '#length', (text) => /\d/.test(text) && text !== before);
}

/** Opens a fresh page on a mesh and waits for its picture. */
export async function openMesh(browser, service, mesh, more = '', options = {}) {
  const page = await newPage(browser, options);
  await page.goto(`${service.url}#mesh=${mesh}${more}`);
  await ready(page);
  return page;
}

/** Waits until the mesh's picture has come to rest. */
export async function settled(page) {
  let before = null;
  for (const end = Date.now() + PATIENCE; Date.now() < end; ) {
    const now = await page.screenshot({ clip: MESH });
    if (before?.equals(now)) return now;
    before = now;
    await page.waitForTimeout(150);
  }
  throw new Error('the picture does not come to rest');
}

/** Where the mesh is on a wide page: left of the panel, above the legend and the hint. */
export const MESH = { x: 0, y: 0, width: 860, height: 640 };

/** Takes a picture of the whole page for people, and of `clip` for numbers. */
export async function picture(page, name, clip = MESH) {
  await settled(page);
  if (VIEWER_PICTURES) await page.screenshot({ path: join(VIEWER_PICTURES, `${name}.png`) });
  return page.screenshot({ clip });
}

/** Runs `measure` in a blank page on the pixels (RGBA) of pictures of one size. */
async function onPixels(browser, pictures, measure) {
  const page = await browser.newPage();
  try {
    return await page.evaluate(
      async ([encoded, source]) => {
        const all = await Promise.all(
          encoded.map(async (text) => {
            const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
            const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
            const sheet = new OffscreenCanvas(image.width, image.height).getContext('2d');
            sheet.drawImage(image, 0, 0);
            return sheet.getImageData(0, 0, image.width, image.height);
          }),
        );
        return new Function('images', `return (${source})(...images)`)(all);
      },
      [pictures.map((png) => png.toString('base64')), measure.toString()],
    );
  } finally {
    await page.close();
  }
}

/**
 * `colourful`: the share of pixels with a chroma (most minus least of red, green, blue)
 * above 60; `colours`: how many different ones, at 16 steps a channel, cover 0.05 % each;
 * `still`: the share of the picture that is its commonest colour.
 */
export function statistics(browser, png) {
  return onPixels(browser, [png], ({ data, width, height }) => {
    const counts = new Map();
    let colourful = 0;
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = [data[i], data[i + 1], data[i + 2]];
      if (Math.max(r, g, b) - Math.min(r, g, b) > 60) colourful++;
      const key = ((r >> 4) << 8) | ((g >> 4) << 4) | (b >> 4);
      counts.set(key, (counts.get(key) ?? 0) + 1);
    }
    const pixels = width * height;
    return {
      width,
      height,
      colourful: colourful / pixels,
      colours: [...counts.values()].filter((count) => count > 0.0005 * pixels).length,
      still: Math.max(...counts.values()) / pixels,
    };
  });
}

/** The share of pixels that differ by more than 40 of 255 in a channel. */
export function difference(browser, one, other) {
  return onPixels(browser, [one, other], (a, b) => {
    if (a.width !== b.width || a.height !== b.height) return 1;
    let differing = 0;
    for (let i = 0; i < a.data.length; i += 4) {
      const apart = [0, 1, 2].map((c) => Math.abs(a.data[i + c] - b.data[i + c]));
      if (Math.max(...apart) > 40) differing++;
    }
    return differing / (a.width * a.height);
  });
}

/** The share of pixels near a colour (`#rrggbb`), within 30 of 255 in each channel. */
export function shareOf(browser, png, colour) {
  const wanted = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  const source = `({ data, width, height }) => {
    let near = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (${JSON.stringify(wanted)}.every((part, c) => Math.abs(data[i + c] - part) <= 30)) near++;
    }
    return near / (width * height);
  }`;
  return onPixels(browser, [png], source);
}

/** The box of the pixels within a part of a picture that differ from its top left one by more than 40 of 255. */
export function boxOfWhatIsDrawn(browser, png, part = {}) {
  const source = `({ data, width, height }) => {
    const { left, top, right, bottom } = { left: 0, top: 0, right: width, bottom: height, ...${JSON.stringify(part)} };
    const at = (x, y) => data.subarray(4 * (y * width + x), 4 * (y * width + x) + 3);
    const ground = at(left, top);
    const box = { left: right, top: bottom, right: left, bottom: top };
    for (let y = top; y < bottom; y++) {
      for (let x = left; x < right; x++) {
        if (!at(x, y).some((value, channel) => Math.abs(value - ground[channel]) > 40)) continue;
        box.left = Math.min(box.left, x);
        box.right = Math.max(box.right, x + 1);
        box.top = Math.min(box.top, y);
        box.bottom = Math.max(box.bottom, y + 1);
      }
    }
    return box;
  }`;
  return onPixels(browser, [png], source);
}

/** Drops files on the page, as a file manager does: name, bytes, name, bytes, … */
export async function drop(page, ...named) {
  const files = [];
  for (let i = 0; i < named.length; i += 2) files.push([Buffer.from(named[i + 1]).toString('base64'), named[i]]);
  const held = await page.evaluateHandle((all) => {
    const data = new DataTransfer();
    for (const [text, called] of all) {
      data.items.add(new File([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], called));
    }
    return data;
  }, files);
  await page.dispatchEvent('body', 'dragover', { dataTransfer: held });
  if (!(await page.locator('.drop-zone').isVisible())) throw new Error('the page does not say that it may be dropped');
  await page.dispatchEvent('body', 'drop', { dataTransfer: held });
}
