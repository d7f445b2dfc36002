// The disc within a radius: what it measures, how it is set off, undone and in the link.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, picture, reload, settled, textAt, until } from './browser.mjs';
import { difference } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

test('the area within a radius is told and set off; a slider pulled is one step', async () => {
  const page = await openMesh(browser, service, plane);
  assert.equal(await page.getByLabel('Area within a radius').isVisible(), false);
  await page.mouse.click(430, 380);
  await page.waitForSelector('.legend:not([hidden])');
  const field = await settled(page);
  await page.getByLabel('Area within a radius').check();
  const numbers = async () => {
    await page.locator('.disc-part:not(.stale)').waitFor();
    const text = await textAt(page, '#disc-said', (said) => /^[\d.,]+ m² · outline [\d.,]+ m$/.test(said));
    return text.match(/[\d.,]*\d/g).map((number) => Number(number.replaceAll(',', '')));
  };
  const [area, outline] = await numbers();
  const radius = Number(await until(async () => /[#&]disc=([\d.]+)/.exec(page.url())?.[1], 'the disc in the link'));
  // In the middle of a plane it is a circle.
  assert.ok(Math.abs(area / (Math.PI * radius ** 2) - 1) < 0.01, `${area}, ${radius}`);
  assert.ok(Math.abs(outline / (2 * Math.PI * radius) - 1) < 0.01, `${outline}, ${radius}`);
  assert.ok(difference(field, await picture(page, '102-disc')) > 0.05, 'it is set off');
  await page.locator('#disc-radius').focus();
  for (let press = 0; press < 5; press++) await page.keyboard.press('ArrowRight');
  await until(async () => (await numbers())[0] > area, 'a larger disc');
  await page.keyboard.press('Control+z');
  await until(async () => (await numbers())[0] === area, 'as before, in one step');
  await reload(page);
  await until(async () => (await numbers())[0] === area, 'the disc of a link');
  await page.getByLabel('Area within a radius').uncheck();
  assert.ok(difference(field, await settled(page)) < 0.001);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
