// The site in a browser, behind a proxy that takes a prefix off: every page is whole, light in bytes, fit for
// everyone, and asks no other host for anything; in light, in dark or on a phone, as it is drawn for each page
// anew. GEODESICD_SEED repeats a draw, and DOCS_PICTURES has every page in all three.
import assert from 'node:assert/strict';
import { createHash, randomInt } from 'node:crypto';
import { readdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, describe, test } from 'node:test';
import { axe, launch, newPage, until } from '../clients/viewer/browser.mjs';
import { Service } from '../clients/viewer/service.mjs';
import { proxied } from '../clients/viewer/proxy.mjs';

const { DOCS_SITE, DOCS_PICTURES } = process.env;
const MOST_BYTES = 300_000;
const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };

const service = await new Service('--docs', DOCS_SITE).start();
const proxy = await proxied(service);
const browser = await launch();
after(async () => {
  await browser.close();
  await service.end();
});

const files = await readdir(DOCS_SITE, { recursive: true });
const seed = process.env.GEODESICD_SEED || String(randomInt(2 ** 32));
console.log(`GEODESICD_SEED=${seed}`);
/** One of so many, by chance. */
const drawn = (path, count) => createHash('sha256').update(`${seed} ${path}`).digest().readUInt32LE() % count;

const pages = files.filter((name) => name.endsWith('index.html')).map((name) => name.slice(0, -'index.html'.length)).sort();

/** A tab that counts the bytes that come, none out of a cache. */
async function counting(options) {
  const page = await newPage(browser, options);
  const session = await page.context().newCDPSession(page);
  await session.send('Network.enable');
  await session.send('Network.setCacheDisabled', { cacheDisabled: true });
  page.bytes = 0;
  session.on('Network.loadingFinished', ({ encodedDataLength }) => (page.bytes += encodedDataLength));
  return page;
}

/** Opens a page of the site, and waits for all of it. */
async function open(page, path) {
  page.bytes = page.faults.length = page.asked.length = 0;
  await page.goto(`${proxy.url}docs/${path}`, { waitUntil: 'load' });
  // Pictures further down come as they are scrolled to.
  for (const image of await page.locator('main img').all()) {
    await image.scrollIntoViewIfNeeded();
    await image.evaluate((one) => one.decode().catch(() => {})); // one that never comes is told below
  }
  await page.waitForLoadState('networkidle');
  await page.evaluate(() => scrollTo(0, 0));
  // The title in the head fades back.
  await until(() => page.evaluate(() =>
    scrollY === 0 && !document.querySelector('.md-header__title--active') &&
    document.getAnimations().every(({ playState }) => playState !== 'running')), `rest at ${path}`);
}

/** What is wrong with a page as it stands; `rules`: which of axe's, all if none are named. */
async function problemsOf(page, path, rules = {}) {
  const found = [...page.faults];
  for (const url of page.asked) {
    if (!url.startsWith(proxy.url) && !/^(data|blob):/.test(url)) found.push(`asks for ${url}`);
  }
  const broken = await page.evaluate(() =>
    [...document.images].filter((image) => !image.complete || image.naturalWidth === 0).map((image) => image.src));
  found.push(...broken.map((source) => `no picture ${source}`));
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  if (wide > 0) found.push(`${wide} pixels too wide`);
  await page.evaluate(await readFile(axe, 'utf8'));
  const { violations } = await page.evaluate((chosen) => globalThis.axe.run(document, { resultTypes: ['violations'], ...chosen }), rules);
  for (const { id, impact, nodes } of violations) {
    if (impact !== 'serious' && impact !== 'critical') continue;
    found.push(`${id}: ${nodes.slice(0, 2).map(({ target, failureSummary }) => `${target} ${failureSummary}`).join('; ')}`);
  }
  return found.map((problem) => `${path || 'home'}: ${problem}`);
}

async function picture(page, path, name) {
  if (!DOCS_PICTURES) return;
  const called = path.replaceAll('/', '-').replace(/-$/, '') || 'home';
  await page.screenshot({ path: join(DOCS_PICTURES, `${called}-${name}.png`) });
}

// Side by side, as each waits now and then for its network to be quiet.
describe('all pages', { concurrency: 3 }, () => {
  // Dark pages have the parts of light ones, in other colours.
  const ways = [
    ['light', {}, {}],
    ['dark', { colorScheme: 'dark' }, { runOnly: { type: 'rule', values: ['color-contrast'] } }],
    ['phone', PHONE, {}],
  ];
  for (const [index, [name, options, rules]] of ways.entries()) {
    test(name, { timeout: 1_200_000 }, async () => {
      assert.ok(pages.length >= 20, `${pages.length} pages`);
      const [weights, problems] = [[], []];
      const page = await counting(options);
      for (const path of pages) {
        if (!DOCS_PICTURES && drawn(path, ways.length) !== index) continue;
        await open(page, path);
        await picture(page, path, name);
        weights.push([path || 'home', page.bytes]);
        if (page.bytes > MOST_BYTES) problems.push(`${path} has ${page.bytes} bytes`);
        problems.push(...(await problemsOf(page, path, rules)));
      }
      await page.context().close();
      weights.sort((one, other) => other[1] - one[1]);
      console.log(`${name}: ${weights.map(([path, bytes]) => `${path} ${Math.round(bytes / 1000)} kB`).join(', ')}`);
      assert.ok(weights.at(-1)[1] > 10_000, 'bytes are counted');
      assert.deepEqual(problems, []);
    });
  }
});

test('the search finds words of pages, without another host', async () => {
  const page = await counting();
  await open(page, '');
  await page.locator('input[name=query]').click();
  await page.locator('input[name=query]').pressSequentially('digest_mismatch');
  await page.locator('.md-search-result__link[href*="errors/"]').first().waitFor();
  assert.deepEqual(await problemsOf(page, 'search'), []);
  await page.context().close();
});

test('a session is copied without prompts and output', async () => {
  const page = await newPage(browser, { permissions: ['clipboard-read', 'clipboard-write'] });
  await page.goto(`${proxy.url}docs/tutorials/tape_measure/`);
  await page.locator('[data-clipboard-target]').first().click();
  await page.getByText('Copied to clipboard').waitFor();
  const lines = (await page.evaluate(() => navigator.clipboard.readText())).trim().split('\n');
  assert.match(lines[0], /^HEAD=\$\(sha256sum /);
  assert.deepEqual(lines.map((line) => line.split(/[ =]/)[0]), ['HEAD', 'MARKS', 'curl']);
  await page.context().close();
});

test('an error leads to its heading: behind a prefix, and without a site to the page of the API', async () => {
  const page = await counting();
  await open(page, 'errors#mesh_unknown');
  assert.equal(page.url(), `${proxy.url}docs/errors/#mesh_unknown`);
  assert.equal(await page.locator('h3#mesh_unknown').count(), 1);
  await page.context().close();

  const bare = await new Service().start();
  try {
    const { type, code } = await bare.json('/v1/meshes/none');
    assert.equal(type, `/docs/errors/#${code}`);
    const other = await newPage(browser);
    await other.goto(new URL(type, bare.url).href);
    await other.locator(`tr#${code}`).waitFor();
    assert.equal(new URL(other.url()).pathname, '/docs/api/');
    await other.goto(new URL('/docs', bare.url).href);
    assert.equal(new URL(other.url()).pathname, '/docs/api/');
    await other.context().close();
  } finally {
    await bare.end();
  }
});

test('a wrong address is answered by a page that leads back to the guide', async () => {
  const page = await counting();
  const reply = await page.goto(`${proxy.url}docs/start/none/there`);
  assert.equal(reply.status(), 404);
  // The browser itself reports the 404, for which it was asked.
  const faults = page.faults.filter((fault) => !/404/.test(fault));
  page.faults.length = 0;
  assert.deepEqual([...faults, ...(await problemsOf(page, 'a wrong address'))], []);
  await picture(page, 'missing', 'light');
  assert.ok(await page.evaluate(() => document.styleSheets[0].cssRules.length > 10), 'it has its style');
  await page.getByRole('link', { name: 'The guide' }).click();
  await page.waitForURL(`${proxy.url}docs/`);
  await page.context().close();
});

test('a browser shows the contract as text', async () => {
  const page = await newPage(browser);
  await page.goto(`${proxy.url}openapi.yaml`);
  assert.match(await page.locator('body').innerText(), /^openapi: 3\.1/);
  await page.context().close();
});
