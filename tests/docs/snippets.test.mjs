// Code that readers copy: the pages' JavaScript runs in a page of the service, and the tabs of the API's
// page say three times the same request, each of which the service takes.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { copyFile, mkdtemp, readdir, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { promisify } from 'node:util';
import { launch, newPage, until } from '../clients/viewer/browser.mjs';
import { Service } from '../clients/viewer/service.mjs';
import { bundle, installClient } from './bundled.mjs';

const { DOCS_PYTHON, VIEWER_SAMPLES } = process.env;
const DOCS = new URL('../../docs/', import.meta.url).pathname;
const run = promisify(execFile);

const service = await new Service().start();
const browser = await launch();
const folder = await mkdtemp(join(tmpdir(), 'snippets_'));
after(async () => {
  await browser.close();
  await service.end();
  await rm(folder, { recursive: true, force: true });
});

const blocksOf = (text) => [...text.matchAll(/^```js\n(.*?)^```$/gms)].map(([, code]) => code);

test('the JavaScript of the pages runs in a page of the service', { timeout: 300_000 }, async () => {
  const files = (await readdir(DOCS, { recursive: true })).filter((name) => name.endsWith('.md'));
  let ran = 0;
  for (const file of files.sort()) {
    const blocks = blocksOf(await readFile(join(DOCS, file), 'utf8'));
    if (!blocks.length) continue;
    ran += blocks.length;
    const script = await bundle(`${blocks.join('\n')}\ndocument.body.dataset.state = 'done';`);
    const page = await newPage(browser);
    await page.route('**/snippet.html', (route) => route.fulfill({
      contentType: 'text/html', body: '<!doctype html><link rel="icon" href="data:,"><script type="module" src="snippet.js"></script>' }));
    await page.route('**/snippet.js', (route) => route.fulfill({ contentType: 'text/javascript', body: script }));
    await page.route('**/torus_knot.glb', async (route) => route.fulfill({ body: await readFile(join(VIEWER_SAMPLES, 'torus_knot.glb')) }));
    const said = [];
    page.on('console', (message) => said.push(message.text()));
    await page.goto(`${service.url}snippet.html`);
    await until(async () => page.faults.length || (await page.locator('body[data-state=done]').count()), `the end of ${file}`);
    // A click that misses is an answer (422); the browser tells of its status.
    assert.deepEqual(page.faults.filter((fault) => !/status of 422/.test(fault)), [], file);
    console.log(`${file}: ${said.join(' | ').slice(0, 200)}`);
    assert.ok(!said.some((text) => /undefined|NaN|false/.test(text)), `${file} says ${said}`);
    await page.context().close();
  }
  assert.ok(ran >= 3, `${ran} blocks`);
});

/** The texts of all operations in a language, as the page shows them once it knows the meshes. */
async function textsIn(language) {
  const page = await newPage(browser);
  await page.goto(`${service.url}docs/api/`);
  await page.locator('#mesh-ids option').first().waitFor({ state: 'attached' });
  await page.getByRole('tab', { name: language, exact: true }).first().click();
  const texts = await page.$$eval('section.operation[data-operation]', (sections) => sections.map((section) => [
    section.dataset.operation, section.querySelector('[role=tabpanel]:not([hidden]) pre').textContent]));
  assert.deepEqual(page.faults, []);
  await page.context().close();
  // What takes away comes last.
  return texts.sort(([one], [other]) => one.startsWith('DELETE') - other.startsWith('DELETE'));
}

/**
 * What an operation may answer when its own example names a job or a mesh that is not there, or a
 * site that this service does not have.
 */
const isExcused = (operation, complaint) =>
  (operation.endsWith(' /docs/') && /http_307/.test(complaint)) || (operation.includes('{job}') && /job_unknown/.test(complaint)) || (operation.startsWith('DELETE') && /mesh_unknown/.test(complaint));

test('the tabs of every operation say requests that the service takes', { timeout: 1_200_000 }, async () => {
  await installClient(folder);
  // The document's examples speak of the plane, and the page of the first mesh that there is.
  const plane = await service.sample('plane');
  for (const { id } of (await service.json('/v1/meshes')).meshes) {
    if (id !== plane) await fetch(`${service.url}v1/meshes/${id}`, { method: 'DELETE' });
  }
  await copyFile(join(VIEWER_SAMPLES, 'plane.glb'), join(folder, 'mesh.glb'));
  const counts = {};
  for (const [language, name, program, ending] of [
    ['Python', 'one.py', DOCS_PYTHON, ''], ['JavaScript', 'one.mjs', process.execPath, ''], ['curl', 'one.sh', 'bash', ' --fail-with-body'],
  ]) {
    await fetch(`${service.url}v1/meshes`, { method: 'POST', body: await readFile(join(folder, 'mesh.glb')) }); // the last one deleted it
    const texts = await textsIn(language);
    counts[language] = texts.length;
    for (const [operation, text] of texts) {
      assert.ok(text.includes(service.url.replace(/\/$/, '')), `${operation} in ${language} names the server: ${text}`);
      await writeFile(join(folder, name), text + ending);
      try {
        await run(program, [join(folder, name)], { cwd: folder, timeout: 120_000, maxBuffer: 1 << 28, encoding: 'buffer' });
      } catch (error) {
        const complaint = `${error.stdout}${error.stderr}`;
        if (!isExcused(operation, complaint)) assert.fail(`${operation} in ${language}:\n${text}\n${complaint.slice(0, 1500)}`);
      }
    }
  }
  console.log(counts);
  assert.ok(counts.Python > 30 && counts.Python === counts.JavaScript && counts.Python === counts.curl, JSON.stringify(counts));
});
