// The server as it really is: busy for long, gone and back, behind a token.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launch, newPage, openMesh, pathLength, picture, ready, until } from './browser.mjs';
import { difference } from './pixels.mjs';
import { started } from './service.mjs';
import { wavyMesh } from './wavy_mesh.mjs';

let browser;
before(async () => { browser = await launch(); });
after(async () => { await browser.close(); });

test('long work shows its progress, can be cancelled, and the field before stays', async (t) => {
  const service = await started(t);
  const uploaded = await fetch(`${service.url}v1/meshes`, { method: 'POST', body: wavyMesh(420) });
  const { id } = await uploaded.json();
  const page = await openMesh(browser, service, id);
  await page.mouse.click(430, 380);
  await page.waitForSelector('.legend:not([hidden])');
  const was = await picture(page, '30-before-long-work');
  await page.getByLabel('Chen–Han').check();
  const work = page.locator('.work');
  await work.waitFor();
  assert.match(await work.textContent(), /Distances by Chen–Han/);
  await until(async () => /[1-9]\d* %/.test(await work.textContent()), 'progress');
  const jobs = await service.json('/v1/status');
  assert.equal(jobs.jobs.running, 1, 'it is a job');
  await page.screenshot({ path: process.env.VIEWER_PICTURES ? join(process.env.VIEWER_PICTURES, '31-long-work.png') : undefined });
  await work.getByRole('button', { name: 'Cancel' }).click();
  await until(async () => (await work.count()) === 0, 'the work is gone from the page');
  await until(async () => (await service.json('/v1/status')).jobs.running === 0, 'and from the server');
  assert.ok(difference(was, await picture(page, '32-cancelled')) < 0.001, 'the field stays');
  assert.ok(await page.getByLabel('Auto').isChecked(), 'and the method is again that of the field');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

for (const [how, leave] of [
  ['closes the tab', (page) => page.close()],
  ['goes to another page', (page) => page.goto('about:blank')],
]) {
  test(`whoever ${how} leaves no work to the server`, async (t) => {
    // No lease ends it.
    const service = await started(t, '--job-lease-seconds', '80000');
    const uploaded = await fetch(`${service.url}v1/meshes`, { method: 'POST', body: wavyMesh(420) });
    const { id } = await uploaded.json();
    const page = await openMesh(browser, service, id, '&from=90000,0.3,0.3&method=chen_han');
    await until(async () => (await service.json('/v1/status')).jobs.running === 1, 'the job runs');
    await leave(page);
    await until(async () => {
      const { jobs, compute } = await service.json('/v1/status');
      return jobs.running + jobs.queued + compute.running === 0;
    }, 'the job has ended');
    assert.equal(await service.endedJobs('cancelled'), 1, 'because the page asked for it');
    await page.context().close();
  });
}

test('a lost network cancels what was asked for, and it is asked for again', async (t) => {
  const service = await started(t);
  const uploaded = await fetch(`${service.url}v1/meshes`, { method: 'POST', body: wavyMesh(420) });
  const { id } = await uploaded.json();
  const page = await openMesh(browser, service, id, '&from=90000,0.3,0.3&method=chen_han');
  const running = async () => (await service.json('/v1/status')).jobs.running;
  await until(async () => (await running()) === 1, 'the job runs');
  await page.context().setOffline(true);
  await until(async () => await page.locator('.banner').isVisible(), 'the banner');
  await until(async () => (await page.locator('.work').count()) === 0, 'nothing seems to go on');
  await page.context().setOffline(false);
  await until(async () => !(await page.locator('.banner').isVisible()), 'the server is back');
  await page.locator('.work').waitFor();
  await until(async () => (await running()) === 1, 'the job runs again');
  await until(async () => (await service.endedJobs('cancelled')) === 1, 'the end of the first');
  const { jobs } = await service.json('/v1/status');
  assert.equal(jobs.running + jobs.queued, 1, 'one job, not two');
  await page.getByRole('button', { name: 'Cancel' }).click();
  await until(async () => (await running()) === 0, 'and it can be cancelled');
  await page.context().close();
});

test('a server that goes away is waited for, and all goes on when it is back', async (t) => {
  const service = await started(t);
  const page = await openMesh(browser, service, await service.sample('plane'));
  await page.mouse.click(250, 330);
  await page.waitForSelector('.legend:not([hidden])');
  await page.mouse.click(620, 430);
  const first = await pathLength(page);
  const was = await picture(page, '33-before-it-goes');
  await service.stop();
  await page.keyboard.press('3');
  await page.mouse.click(420, 180);
  const banner = page.locator('.banner');
  await until(async () => (await banner.isVisible()) && /does not answer/.test(await banner.textContent()), 'the banner');
  const gone = await picture(page, '34-server-gone', { x: 0, y: 200, width: 860, height: 440 });
  assert.ok(gone.length > 0);
  assert.equal(await page.textContent('#length'), first, 'the last path stays');
  await service.start();
  await until(async () => !(await banner.isVisible()), 'the banner is gone');
  const second = await pathLength(page, first);
  assert.notEqual(second, first, 'the path that was wanted has come');
  assert.ok(difference(was, await picture(page, '35-server-back')) > 0.001);
  assert.deepEqual(page.faults.filter((text) => !/Failed to load resource: net::/.test(text)), []);
  await page.context().close();
});

test('a server that takes a question and says nothing is told, and need not be waited for', async (t) => {
  const service = await started(t);
  const page = await openMesh(browser, service, await service.sample('plane'));
  await page.route(/\/distance/, () => undefined); // never answered
  await page.locator('#vertex').fill('0');
  await page.keyboard.press('Enter');
  const work = page.locator('.work', { hasText: 'waiting for the server' });
  await work.getByRole('button', { name: 'Cancel' }).click();
  await work.waitFor({ state: 'detached' });
  await page.unroute(/\/distance/);
  await page.getByRole('button', { name: 'Clear points' }).click();
  await page.locator('#vertex').fill('1');
  await page.keyboard.press('Enter');
  await page.waitForSelector('.legend:not([hidden])');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a server that asks for a token gets one, and the page goes on', async (t) => {
  const made = execFileSync(process.env.GEODESICD, ['--make-token', 'ann', '--scopes', 'read,upload'], { encoding: 'utf8' });
  const [token, line] = made.trim().split('\n');
  const folder = mkdtempSync(join(tmpdir(), 'viewer_'));
  const file = join(folder, 'tokens');
  writeFileSync(file, `${line}\n`);
  const service = await started(t, '--tokens', file);
  const page = await newPage(browser);
  await page.goto(service.url);
  const trouble = page.locator('.trouble');
  await trouble.waitFor();
  assert.match(await trouble.textContent(), /asks for a token/);
  await trouble.getByRole('button', { name: 'Enter a token' }).click();
  await page.locator('dialog input').fill(token);
  await picture(page, '36-token');
  await page.getByRole('button', { name: 'Use it' }).click();
  await ready(page);
  await page.mouse.click(392, 314);
  await page.waitForSelector('.legend:not([hidden])');
  assert.ok(!page.url().includes(token), 'a token is never in a link');
  assert.deepEqual(page.faults.filter((text) => !/Failed to load resource.*401/.test(text)), []);
  await page.context().close();
  rmSync(folder, { recursive: true });
});
