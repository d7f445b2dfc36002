// Points beyond clicks: undone and redone, by the number of a vertex, out of a text file, and
// what the page says of each.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, openMesh, pathLength, picture, ready, reload, textAt, until } from './browser.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const BOX = 'Points: 12, x y z or f:FACE,b1,b2';

test('what was done is undone and done again, a drag in one step', async () => {
  const page = await openMesh(browser, service, plane);
  const undo = page.getByRole('button', { name: 'Undo' });
  const redo = page.getByRole('button', { name: 'Redo' });
  assert.ok((await undo.isDisabled()) && (await redo.isDisabled()), 'nothing was done yet');
  await page.mouse.click(250, 330);
  await page.mouse.click(620, 430);
  const first = await pathLength(page);
  await page.mouse.move(620, 430);
  await page.mouse.down();
  await page.mouse.move(420, 180, { steps: 12 });
  await page.mouse.up();
  const second = await pathLength(page, first);
  await undo.click();
  await textAt(page, '#length', (text) => text === first);
  await page.keyboard.press('Control+z');
  await until(async () => (await page.locator('.point').count()) === 1, 'the target is gone');
  await page.keyboard.press('Control+Shift+z');
  await textAt(page, '#length', (text) => text === first);
  await redo.click();
  await until(async () => await redo.isDisabled(), 'all is done again');
  await until(async () => (await page.textContent('#length')) !== first, 'the second path');
  assert.notEqual(second, first);
  await page.keyboard.press('x');
  await undo.click();
  assert.equal(await page.locator('.point').count(), 2, 'cleared points come back');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a point tells its vertex, face and place, and a vertex is placed by its number', async () => {
  const page = await openMesh(browser, service, plane);
  await page.mouse.click(250, 330);
  const told = await textAt(page, '#place', (text) => text.startsWith('Source'));
  assert.match(told, /^Source: near vertex [\d,]+, face [\d,]+, at \([\d.]+, [\d.]+, 0\)$/);
  const [, face, x, y] = /face ([\d,]+), at \(([\d.]+), ([\d.]+)/.exec(told);
  await until(async () => page.url().includes('from='), 'the link');
  const from = /from=([\d.,]+)/.exec(page.url())[1];
  assert.equal(from.split(',')[0], face.replaceAll(',', ''));
  const { points } = await service.json(`/v1/meshes/${plane}/nearest?point=f:${from}`);
  assert.ok(Math.hypot(points[0].xyz[0] - x, points[0].xyz[1] - y) < 0.01);
  // The tool is the target's now.
  const input = page.getByLabel(BOX);
  await input.fill('9999');
  await page.getByRole('button', { name: 'Place as target' }).click();
  assert.equal(await textAt(page, '#place', (text) => text.startsWith('Target')), 'Target: vertex 9,999, face 19,600, at (99, 99, 0)');
  await pathLength(page);
  await picture(page, '65-vertex');
  await input.fill('10000');
  await input.press('Enter');
  assert.match(await page.locator('.trouble').textContent(), /No such vertex.*0 to 9,999/);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('after a reload a click places a target, as before it, and no source is lost', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&from=400,0.3,0.3&from=15000,0.2,0.2');
  assert.ok(await page.getByLabel('Target', { exact: true }).isChecked());
  await page.mouse.click(300, 380);
  await pathLength(page);
  assert.equal(await page.locator('.point.source').count(), 3);
  await until(async () => page.url().includes('to='), 'the target in the link');
  await reload(page);
  await pathLength(page);
  assert.ok(await page.getByLabel('Target', { exact: true }).isChecked());
  assert.equal(await page.locator('.point').count(), 4);
  // Where no source is left of a link, a source comes first.
  const other = await openMesh(browser, service, plane, '&from=999999,0.3,0.3');
  assert.ok(await other.getByLabel('Source', { exact: true }).isChecked());
  assert.deepEqual([...page.faults, ...other.faults], []);
  await page.context().close();
  await other.context().close();
});

test('who leaves the page at once after a click and comes back finds the point', async () => {
  const page = await openMesh(browser, service, plane);
  await page.mouse.click(300, 380);
  await page.goto('about:blank');
  await page.goBack();
  await ready(page);
  await until(async () => (await page.locator('.point.source').count()) === 1, 'the source');
  await page.context().close();
});

test('one grammar in the box: vertices, faces and places, and what is wrong is said', async () => {
  const page = await openMesh(browser, service, plane);
  const input = page.getByLabel(BOX);
  const place = async (text) => {
    await input.fill(text);
    await input.press('Enter');
  };
  const told = (text) => textAt(page, '#place', (now) => now.includes(text));
  await page.getByLabel('Target', { exact: true }).check();
  await place('v:12');
  await told('Target: vertex 12,');
  await place('13');
  await told('Target: vertex 13,');
  await place('f:40,0.2,0.3');
  await told('face 40,');
  await place('0.5 1 0');
  await told('at (0.5, 1, 0)');
  await place('3, 4.5, 0');
  await told('at (3, 4.5, 0)');
  for (const [wrong, why] of [
    ['v:99999999', /No such vertex.*10,000 vertices, numbered from 0 to 9,999/s],
    ['f:19602,0.1,0.1', /No such face.*19,602 faces/s],
    ['f:3,0.9,0.9', /no barycentric coordinates.*at most 1/s],
    ['f:0.5,0.1,0.1', /face has a whole number/],
    ['0.5', /vertex has a whole number/],
    ['-1', /whole number/],
    ['12 13', /These are 2 numbers.*separated by ;/s],
    ['1; 2', /one target.*These are 2/s],
    ['1; north', /no point.*north/s],
  ]) {
    await place(wrong);
    await until(async () => why.test(await page.locator('.trouble').last().textContent()), `${wrong}: ${why}`);
    assert.equal(await input.inputValue(), wrong);
  }
  await told('at (3, 4.5, 0)');
  await page.getByLabel('Source', { exact: true }).check();
  // Lines that are pasted are several points.
  await input.fill('');
  await input.evaluate((box) => {
    const clipboardData = new DataTransfer();
    clipboardData.setData('text', '12\n40 50 0\r\nf:7,0.1,0.1\n');
    box.dispatchEvent(new ClipboardEvent('paste', { clipboardData, bubbles: true, cancelable: true }));
  });
  assert.equal(await input.inputValue(), '12; 40 50 0; f:7,0.1,0.1');
  await input.press('Enter');
  await until(async () => (await page.locator('.point.source').count()) === 3, 'three sources');
  await page.getByLabel('Via', { exact: true }).check();
  await place('v:500 v:600');
  await until(async () => (await page.locator('.point.via').count()) === 2, 'two via points');
  const many = Array.from({ length: 120 }, (_, index) => `v:${50 * index}`).join(';');
  await place(many);
  await page.locator('.trouble', { hasText: /No more via points.*a hundred/ }).waitFor();
  assert.equal(await page.locator('.point.via').count(), 100);
  await page.getByLabel('Loop', { exact: true }).check();
  await place(many);
  await page.locator('.trouble', { hasText: /No more points of a loop.*a hundred/ }).waitFor();
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('who comes back to a mesh finds its points, its measures and its steps', async () => {
  const knot = await service.sample('torus_knot');
  const page = await openMesh(browser, service, plane);
  const undo = page.getByRole('button', { name: 'Undo' });
  await page.mouse.click(250, 330);
  await page.mouse.click(620, 430);
  const length = await pathLength(page);
  await page.keyboard.press('k');
  await textAt(page, '.measures .number', (text) => text === length);
  await page.selectOption('#mesh', knot);
  await ready(page);
  assert.equal((await page.locator('.point').count()) + (await page.locator('.measures li').count()), 0);
  assert.ok(await undo.isDisabled(), 'nothing was done on this one');
  await page.mouse.click(392, 314);
  await until(async () => (await page.locator('.point').count()) === 1, 'a source on the other');
  await page.selectOption('#mesh', plane);
  await ready(page);
  await textAt(page, '#length', (text) => text === length);
  await textAt(page, '.measures .number', (text) => text === length);
  await undo.click();
  await until(async () => (await page.locator('.measures li').count()) === 0, 'the measure is undone');
  await undo.click();
  await until(async () => (await page.locator('.point').count()) === 1, 'the target is undone');
  await page.selectOption('#mesh', knot);
  await ready(page);
  assert.equal(await page.locator('.point').count(), 1);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('Escape takes a drag back, and there is nothing to undo of it', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3');
  await page.mouse.click(620, 430);
  const length = await pathLength(page);
  const place = await page.textContent('#place');
  await page.mouse.move(620, 430);
  await page.mouse.down();
  await page.mouse.move(420, 180, { steps: 12 });
  await until(async () => (await page.textContent('#place')) !== place, 'the target moves');
  await page.keyboard.press('Escape');
  await until(async () => (await page.textContent('#place')) === place, 'it is back');
  await page.mouse.move(300, 200, { steps: 3 });
  await page.mouse.up();
  await textAt(page, '#length', (text) => text === length);
  assert.equal(await page.textContent('#place'), place, 'what the pointer does after it is no drag');
  await page.getByRole('button', { name: 'Undo' }).click();
  await until(async () => (await page.locator('.point').count()) === 1, 'what is undone is the click before the drag');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('an old message goes with the next success, or by Escape', async () => {
  const page = await openMesh(browser, service, plane);
  const input = page.getByLabel(BOX);
  const troubles = page.locator('.trouble');
  const wrong = async () => {
    await input.fill('north');
    await input.press('Enter');
    await troubles.waitFor();
  };
  await wrong();
  await input.fill('12');
  await input.press('Enter');
  await until(async () => (await troubles.count()) === 0, 'a typed point takes it away');
  await wrong();
  await page.mouse.click(300, 380);
  await until(async () => (await troubles.count()) === 0, 'a click, too');
  await pathLength(page);
  await wrong();
  // In the box and out of it; while something is under way it is stopped first.
  await until(async () => { await page.keyboard.press('Escape'); return (await troubles.count()) === 0; }, 'Escape closes it');
  assert.equal(await page.locator('.point').count(), 2);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('links take points as the API has them, and tell what they cannot read', async () => {
  const page = await openMesh(browser, service, plane, '&from=v:12&from=f:40,0.2,0.3&to=v:9999&via=v:5000');
  await pathLength(page);
  assert.equal(await page.locator('.point').count(), 4);
  assert.equal(await page.locator('.trouble').count(), 0);
  assert.ok(await page.getByRole('button', { name: 'Undo' }).isDisabled(), 'nothing was done by the reader');
  await until(async () => /from=\d+,[\d.,]+&from=40,0\.2,0\.3&via=\d+,.*to=\d+,/.test(page.url()), 'the link as the page writes it');
  // Another link on the same page, with faults.
  await page.evaluate((hash) => { location.hash = hash; }, `#mesh=${plane}&from=v:13&from=v:99999999&from=north&to=p:1,2,3`);
  const trouble = page.locator('.trouble');
  await trouble.waitFor();
  assert.match(await trouble.textContent(), /link were left out.*not on the mesh.*from=north · to=p:1,2,3 · from=v:99999999/s);
  await until(async () => !/north|v:|p:/.test(new URL(page.url()).hash), 'the address says what is shown');
  assert.equal(await page.locator('.point').count(), 1);
  await page.locator('.trouble button[aria-label="Close this message"]').click();
  const other = await openMesh(browser, service, plane, '&from=v:abc');
  assert.match(await other.locator('.trouble').textContent(), /from=v:abc/);
  await until(async () => !other.url().includes('abc'), 'the address without it');
  assert.deepEqual([...page.faults, ...other.faults], []);
  await page.context().close();
  await other.context().close();
});

test('a file of sources: what cannot be read is told by its line, and too many are counted', async () => {
  const page = await openMesh(browser, service, plane);
  const give = (text) =>
    page.locator('input[aria-label="File of sources"]').setInputFiles({ name: 'some.txt', mimeType: 'text/plain', buffer: Buffer.from(text) });
  await give('vertex\n# all kinds\n12\nv:13 # one more\np:1,2,0\n4 5 0\n6,7,0\nf:3,0.2,0.3\n');
  await until(async () => (await page.locator('.points').textContent()).includes('Source 6'), 'six sources');
  assert.equal(await page.locator('.trouble').count(), 0);
  await give('12\n13\nnorth\n14 15\n\nv:10000\n16\nf:1,2,3\n');
  const trouble = page.locator('.trouble');
  await trouble.waitFor();
  const told = await trouble.textContent();
  assert.match(told, /4 of 7 points were left out.*some\.txt · line 3: north · line 4: 14 15 · line 6: v:10000 · and 1 more/s);
  await until(async () => (await page.locator('.point.source').count()) === 3, 'those that can be read');
  await page.getByRole('button', { name: 'Close this message' }).click();
  await give('10 11\nv:10000\n');
  assert.match(await trouble.textContent(), /No sources in this file.*line 1: 10 11 · line 2: v:10000/s);
  assert.equal(await page.locator('.point.source').count(), 3, 'what was there stays');
  await page.getByRole('button', { name: 'Close this message' }).click();
  await give(Array.from({ length: 2345 }, (_, n) => `${n}`).join('\n'));
  await page.locator('.remark').waitFor();
  assert.match(await page.locator('.remark').textContent(), /No more sources.*first of 2,345 were taken/s);
  assert.equal(await page.locator('.trouble:not(.remark)').count(), 0, 'that is no error');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('many sources come out of a text file, and divide the surface', async () => {
  const page = await openMesh(browser, service, plane);
  const lines = ['# sources', ...Array.from({ length: 14 }, (_, n) => `${700 * n + 55}`), '50.5 2.25 0.1', ''];
  const give = (name, text) =>
    page.locator('input[aria-label="File of sources"]').setInputFiles({ name, mimeType: 'text/plain', buffer: Buffer.from(text) });
  await give('sources.txt', lines.join('\n'));
  await until(async () => (await page.locator('.points').textContent()).includes('and 9 sources more'), 'fifteen sources');
  await page.waitForSelector('.legend:not([hidden])');
  await until(async () => new URLSearchParams(new URL(page.url()).hash.slice(1)).getAll('from').length === 15, 'the link has them');
  await page.getByLabel('Regions').check();
  await textAt(page, '.legend h2', (text) => text === 'Nearest of 15');
  await picture(page, '66-fifteen-sources');
  // Every one of them can be removed by itself.
  await page.getByRole('button', { name: 'and 9 sources more' }).click();
  assert.equal(await page.locator('.points .source').count(), 15);
  await page.getByRole('button', { name: 'Remove Source 15' }).click();
  await page.getByRole('button', { name: 'Remove Source 9', exact: true }).click();
  await textAt(page, '.legend h2', (text) => text === 'Nearest of 13');
  await page.getByRole('button', { name: 'Only the first 6 sources' }).click();
  assert.equal(await page.locator('.points .source').count(), 6);
  assert.match(await page.locator('.points').textContent(), /and 7 sources more/);
  await give('poem.txt', 'no numbers\n');
  assert.match(await page.locator('.trouble').textContent(), /No sources in this file.*poem\.txt/s);
  assert.equal(await page.getByRole('button', { name: 'Undo' }).isDisabled(), false);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('places are typed as p:x,y,z, among vertex numbers too', async () => {
  const page = await openMesh(browser, service, plane);
  const input = page.getByLabel(BOX);
  const place = async (text) => {
    await input.fill(text);
    await input.press('Enter');
  };
  await place('p:50.25,2.5,0');
  assert.match(await textAt(page, '#place', (text) => text.startsWith('Source')), /at \(50\.25, 2\.5, 0\)$/);
  assert.equal(await input.inputValue(), '');
  await page.getByLabel('Add').check();
  await place('7; 9999;p:1,2,0  p:3e1,4,0.5');
  await until(async () => (await page.locator('.point').count()) === 5, 'four more');
  for (const wrong of ['p:1,2', 'p:1,2,3,4', 'p:a,b,c', 'north', 'p:,,', '1e999']) {
    await place(wrong);
    await until(async () => /no point.*p:x,y,z/s.test(await page.locator('.trouble').textContent()), wrong);
    assert.equal(await input.inputValue(), wrong, 'what was typed stays, to be mended');
    await page.getByRole('button', { name: 'Close this message' }).click();
  }
  assert.equal(await page.locator('.point').count(), 5);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

for (const [how, count] of [['a typed line', 1], ['a file', 2], ['a long file', 40]]) {
  test(`points of ${how} that are far from the surface are remarked on, and placed`, async () => {
    const page = await openMesh(browser, service, plane);
    const remark = page.locator('.remark');
    const give = async (z) => {
      if (how === 'a typed line') {
        await page.getByLabel(BOX).fill(`p:5,5,${z}`);
        return page.getByRole('button', { name: 'Place as' }).click();
      }
      const text = Array.from({ length: count }, (_, n) => `${n} 5 ${z}`).join('\n');
      return page.locator('input[aria-label="File of sources"]').setInputFiles({ name: 'far.xyz', mimeType: 'text/plain', buffer: Buffer.from(text) });
    };
    await give(500);
    await remark.waitFor();
    const told = await remark.textContent();
    assert.match(told, /Far from the surface.*unit/s);
    assert.match(told, count === 1 ? /500.0 away/ : new RegExp(`${count} of ${count} points, up to 500.0 away`));
    await page.waitForSelector('.legend:not([hidden])');
    await picture(page, `67-far-${count}`);
    await page.getByRole('button', { name: 'Close this message' }).click();
    await page.keyboard.press('x');
    await give(0);
    await page.locator('.point').first().waitFor();
    assert.equal(await remark.count(), 0, 'near points are taken without a word');
    assert.deepEqual(page.faults, []);
    await page.context().close();
  });
}

test('a path is asked for once, and not again when its field has come', async () => {
  const page = await newPage(browser);
  let shown;
  const pathIsShown = new Promise((resolve) => { shown = resolve; });
  await page.route(/\/distance\?/, async (route) => {
    await pathIsShown;
    await route.continue();
  });
  await page.goto(`${service.url}#mesh=${plane}&from=5,0.3,0.3&to=9000,0.3,0.3&method=dijkstra`);
  const length = await pathLength(page);
  assert.notEqual(await page.textContent('.legend h2'), 'Distance');
  shown();
  await textAt(page, '.legend h2', (text) => text === 'Distance');
  const paths = () => page.asked.filter((url) => url.includes('/path?')).length;
  assert.equal(paths(), 1);
  // Another one is, and the first again when the click is undone.
  await page.mouse.click(620, 430);
  await pathLength(page, length);
  assert.equal(paths(), 2);
  await page.keyboard.press('Control+z');
  await textAt(page, '#length', (text) => text === length);
  assert.equal(paths(), 3);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
