// Debian's Chromium with WebGL in software, pages that note what goes wrong in them, and
// pictures of them; pixels.mjs says in numbers what those show.
import { createRequire } from 'node:module';
import { join } from 'node:path';

const { CHROMIUM, VIEWER_PICTURES, VIEWER_SOURCES } = process.env;
const require = createRequire(join(VIEWER_SOURCES, 'package.json'));
const { chromium } = require('playwright-core');
export const axe = require.resolve('axe-core/axe.min.js');

export const PATIENCE = Number(process.env.VIEWER_PATIENCE ?? 120_000); // milliseconds; machines are loaded
export const WIDE = { width: 1200, height: 760 };

// What Playwright 1.60 switches off, as the flag here replaces its own, and Chromium's lists of suggestions: each
// window makes two pages for them, which take as long as the viewer.
const NOT = [
  'AvoidUnnecessaryBeforeUnloadCheckSync', 'BoundaryEventDispatchTracksNodeRemoval', 'DestroyProfileOnBrowserClose',
  'DialMediaRouteProvider', 'GlobalMediaControls', 'HttpsUpgrades', 'LensOverlay', 'MediaRouter', 'PaintHolding',
  'ThirdPartyStoragePartitioning', 'Translate', 'AutoDeElevate', 'RenderDocument', 'OptimizationHints',
  'WebUIOmniboxPopup', 'WebUIOmniboxAimPopup',
];
const FLAGS = [
  '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--disable-dev-shm-usage',
  // Debian lets a GPU paint the page. Without one that is done by the same slow emulation as WebGL.
  '--disable-gpu-compositing', `--disable-features=${NOT.join()}`,
];

/** A browser; `smooth`: with the edges of what WebGL draws smoothed, which doubles its work, for pictures to be kept. */
export async function launch({ smooth = false } = {}) {
  return chromium.launch({ executablePath: CHROMIUM, args: smooth ? FLAGS : [...FLAGS, '--webgl-antialiasing-mode=none'] });
}

// The browser itself reads what WebGL has drawn, to put it on the page, and complains of that. A page that does so
// is told of here, as that makes it slow anywhere.
const OWN_READS = /GL Driver Message .* GPU stall due to ReadPixels/;
function tellOfReads() {
  WebGL2RenderingContext.prototype.readPixels = () => console.warn('the page reads pixels');
}

/** A page in a context of its own; `page.faults` are its errors, `page.asked` the targets it asked for. */
export async function newPage(browser, options = {}) {
  const context = await browser.newContext({ viewport: WIDE, acceptDownloads: true, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.faults = [];
  page.asked = [];
  await page.addInitScript(tellOfReads);
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !OWN_READS.test(message.text())) page.faults.push(message.text());
  });
  page.on('pageerror', (error) => page.faults.push(error.stack));
  page.on('request', (request) => page.asked.push(request.url()));
  page.route = routeForSure(page);
  return page;
}

/** Chromium says that it intercepts requests of a page a little before it does: a request of the test's own tells. */
function routeForSure(page) {
  const route = page.route.bind(page);
  return async (...given) => {
    await route(...given);
    if (page.url() === 'about:blank') return; // whatever is opened later is intercepted
    let intercepted = false;
    const probe = /\?probe$/;
    await route(probe, (one) => {
      intercepted = true;
      return one.fulfill({ body: '' });
    });
    await until(async () => {
      await page.evaluate(() => fetch('?probe').then((reply) => reply.text()));
      return intercepted;
    }, 'an intercepted request');
    await page.unroute(probe);
  };
}

/** A page for which the server's status lacks these limits, as an older one's does. */
export async function pageWithout(browser, ...limits) {
  const page = await newPage(browser);
  await page.route(/\/v1\/status/, async (route) => {
    const reply = await route.fetch();
    const status = await reply.json();
    for (const limit of limits) delete status.limits[limit];
    await route.fulfill({ response: reply, json: status });
  });
  return page;
}

export async function ready(page, state = 'ready') {
  await page.waitForSelector(`body[data-state="${state}"]`);
}

/** Loads the page again, once its link says all that was done. */
export async function reload(page) {
  await page.waitForSelector('body:not([data-link])');
  await page.reload();
}

/**
 * Asks `condition` until its answer is true-like, and gives that. From outside: the page's policy allows no eval.
 * `seen` says what there was instead.
 */
export async function until(condition, what, seen = () => '') {
  const end = Date.now() + PATIENCE;
  for (;;) {
    const answer = await condition();
    if (answer) return answer;
    if (Date.now() > end) throw new Error(`never came: ${what}${seen()}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/** The text at a selector once it fulfils a condition. */
export function textAt(page, selector, fits) {
  let text;
  const condition = async () => {
    text = await page.locator(selector).textContent();
    return fits(text) && text;
  };
  return until(condition, `text at ${selector}`, () => `; the last was '${text}', at ${page.url()}`);
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

/** The picture of the mesh, or of another part of the page, once it has come to rest. */
export async function settled(page, clip = MESH) {
  let before = null;
  for (const end = Date.now() + PATIENCE; Date.now() < end; ) {
    const now = await page.screenshot({ clip });
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
  const seen = await settled(page, clip);
  if (VIEWER_PICTURES) await page.screenshot({ path: join(VIEWER_PICTURES, `${name}.png`) });
  return seen;
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
