// Answers that come late, come out of order or do not come: what is seen is always that of the
// present mesh and points.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drop, newPage, openMesh, pathLength, ready, settled, until } from './browser.mjs';
import { difference } from './pixels.mjs';
import { served } from './served.mjs';
import { wavyMesh } from './wavy_mesh.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const hole = await service.sample('plane_one_hole');
const points = (page) => page.locator('.point').count();
const isStale = (page) => page.locator('.result.stale').count().then((count) => count > 0);

/** Holds back what fits until `release`; then `act` decides. `waiting` are those that are held. */
async function hold(page, pattern, act = (route) => route.continue()) {
  const waiting = [];
  let open = false;
  const handler = async (route) => {
    if (!open) await new Promise((go) => waiting.push(go));
    await act(route).catch(() => undefined); // it was cancelled meanwhile
  };
  await page.route(pattern, handler);
  return {
    waiting,
    release: () => {
      open = true;
      waiting.splice(0).forEach((go) => go());
    },
    end: () => page.unroute(pattern, handler),
  };
}

const problem = (status, code) => (route) =>
  route.fulfill({ status, contentType: 'application/problem+json', body: JSON.stringify({ code, status, title: code, detail: 'made up' }) });

async function place(page, text) {
  await page.locator('#vertex').fill(text);
  await page.keyboard.press('Enter');
}

for (const [how, answer, leave] of [
  ['is cancelled', undefined, (page) => page.locator('.work .cancel').click()],
  ['is not there', problem(404, 'mesh_unknown'), (_, held) => held.release()],
]) {
  test(`a mesh that ${how} leaves the one before, with its points`, async () => {
    const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&to=19000,0.25,0.25');
    const length = await pathLength(page);
    const held = await hold(page, '**/geometry**', answer);
    await page.selectOption('#mesh', hole);
    await until(() => held.waiting.length > 0, 'the question for the mesh');
    // What is still drawn is not the chosen mesh: no point is placed on it.
    await page.mouse.click(430, 340);
    assert.equal(await points(page), 0);
    page.asked.length = 0;
    await leave(page, held);
    await until(async () => (await page.locator('#mesh').inputValue()) === plane, 'the mesh before is chosen again');
    assert.equal(await pathLength(page), length);
    await page.waitForSelector('.legend:not([hidden])');
    assert.equal(await points(page), 2);
    assert.match(await page.title(), /^plane\.glb ·/);
    if (answer) assert.match(await page.locator('.trouble').textContent(), /not on the server/);
    await page.keyboard.press('3');
    await page.mouse.click(330, 250);
    await until(async () => page.url().includes(`mesh=${plane}`) && !(await isStale(page)) && (await page.textContent('#length')) !== length, 'the path on it');
    assert.deepEqual(page.asked.filter((url) => url.includes(hole) && !url.includes('geometry')), [], 'nothing is asked of the other');
    await page.context().close();
  });
}

const legend = (page) => page.evaluate(() => {
  const shown = document.querySelector('.legend');
  return shown && !shown.hidden ? shown.textContent : null;
});

/** The next answer of a question that fits, once the page can have taken it. */
async function answered(page, fits, act) {
  const end = new Promise((resolve) => {
    const done = (request) => fits(request.url()) && resolve();
    page.on('requestfinished', done);
    page.on('requestfailed', done);
  });
  await act();
  await end;
  for (let turns = 0; turns < 5; turns++) await page.evaluate(() => new Promise((go) => setTimeout(go)));
}

test('a mesh on its way does not take the place of one that is chosen again', async () => {
  const page = await openMesh(browser, service, plane);
  const held = await hold(page, '**/geometry**');
  // The question ends when it is given up, or else when its answer is there.
  await answered(page, (url) => url.includes(`${hole}/geometry`), async () => {
    await page.selectOption('#mesh', hole);
    await until(() => held.waiting.length > 0, 'the question for the mesh');
    await page.selectOption('#mesh', plane);
    await ready(page);
    held.release();
  });
  await page.mouse.click(430, 340);
  await page.waitForSelector('.legend:not([hidden])');
  assert.match(await page.title(), /^plane\.glb ·/);
  await page.context().close();
});

test('undone while its field is on its way, a point takes that field along', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3');
  const was = await until(() => legend(page), 'the first field');
  const held = await hold(page, '**/distance**');
  await page.keyboard.press('1'); // a source, in the place of the other
  await place(page, '0');
  await until(() => held.waiting.length > 0, 'the question for the second');
  await answered(page, (url) => url.includes('/distance'), async () => {
    await page.getByRole('button', { name: 'Undo' }).click();
    held.release();
  });
  assert.equal(await legend(page), was);
  // The same point again has its own field all the same.
  await page.getByRole('button', { name: 'Redo' }).click();
  await until(async () => (await legend(page)) !== was, 'the second field');
  await page.context().close();
});

test('back at the method before, nothing of the other one comes', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3');
  const was = await until(() => legend(page), 'the first field');
  const held = await hold(page, '**/distance**');
  await page.getByLabel('Dijkstra').check();
  await until(() => held.waiting.length > 0, 'the question for the second');
  await answered(page, (url) => url.includes('/distance'), async () => {
    await page.getByLabel('Auto').check();
    held.release();
  });
  assert.equal(await legend(page), was);
  await page.context().close();
});

test('a field that does not come takes the one of other points away', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3');
  const was = await until(() => legend(page), 'the field');
  await page.route('**/distance**', problem(413, 'too_large'));
  await page.keyboard.press('1'); // a source, in the place of the other
  await place(page, '0');
  await page.locator('.trouble').waitFor();
  await until(async () => (await legend(page)) === null, 'the old field is gone');
  await page.getByRole('button', { name: 'Undo' }).click();
  await until(async () => (await legend(page)) === was, 'with its own point it is back');
  await page.context().close();
});

test('a straight line that does not come takes the one before away', async () => {
  const page = await openMesh(browser, service, plane, '&arrow=9700,0.3,0.3;1,0,0;20');
  const said = page.locator('.arrow-part .facts');
  await until(async () => /Ends/.test(await said.textContent()), 'the line');
  await page.route('**/trace**', problem(413, 'too_large'));
  await page.keyboard.press('5');
  await place(page, '20');
  await page.locator('.trouble').waitFor();
  await until(async () => (await said.textContent()) === '', 'the old line is gone');
  await page.context().close();
});

test('stopped, a field of other points is not left under the new ones', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3');
  await until(() => legend(page), 'the field');
  const held = await hold(page, '**/distance**');
  await page.keyboard.press('1'); // a source, in the place of the other
  await place(page, '0');
  await until(() => held.waiting.length > 0, 'the question');
  await page.locator('canvas').first().focus();
  await page.keyboard.press('Escape');
  await until(async () => (await legend(page)) === null, 'the old field is gone');
  await page.context().close();
});

test('a path of other points is neither kept nor exported', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&to=19000,0.25,0.25');
  await pathLength(page);
  const keep = page.getByRole('button', { name: 'Keep' });
  await page.getByText('Export', { exact: true }).click();
  const exports = page.getByRole('button', { name: /^Path · / });
  await until(async () => !(await isStale(page)) && (await keep.isEnabled()) && (await exports.first().isEnabled()), 'the path');
  const held = await hold(page, '**/path**', problem(413, 'too_large'));
  await page.keyboard.press('3');
  await page.keyboard.press('1'); // a source, in the place of the other
  await place(page, '0');
  await until(() => held.waiting.length > 0, 'the question');
  const refused = async () => {
    assert.ok(await keep.isDisabled());
    for (const button of await exports.all()) assert.ok(await button.isDisabled());
    await page.locator('canvas').first().focus();
    await page.keyboard.press('k');
    assert.equal(await page.locator('.measures li').count(), 0);
  };
  await refused();
  held.release();
  await page.locator('.trouble').waitFor();
  await refused();
  await page.getByRole('button', { name: 'Undo' }).click();
  await until(() => keep.isEnabled(), 'with its own points it can be kept');
  await page.context().close();
});

for (const [tool, name, before] of [['Add', 'from', 1], ['Via', 'via', 0], ['Loop', 'loop', 0]]) {
  test(`what is placed while the server looks for a typed place stays: ${tool}`, async () => {
    const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&to=19000,0.25,0.25');
    const inLink = () =>
      new URLSearchParams(new URL(page.url()).hash.slice(1)).getAll(name).flatMap((text) => text.split(';')).filter((text) => text !== 'open').length;
    await page.getByLabel(tool, { exact: true }).check();
    const held = await hold(page, '**/nearest**');
    await place(page, 'p:5,5,0');
    await until(() => held.waiting.length > 0, 'the question');
    await place(page, 'v:12');
    await until(() => inLink() === before + 1, 'the vertex');
    held.release();
    await until(() => inLink() === before + 2, 'the place beside it', () => `; in the link are ${inLink()}`);
    assert.deepEqual(page.faults, []);
    await page.context().close();
  });
}

test('a kept measure that fails keeps none after it back', async () => {
  const page = await newPage(browser);
  const kept = (from, to) => `&kept=auto;1;${from},0.3,0.3;${to},0.3,0.3`;
  await page.route('**/path**', (route) => (route.request().url().includes('19000') ? problem(413, 'too_large')(route) : route.continue()));
  await page.goto(`${service.url}#mesh=${plane}${kept(5, 19000)}${kept(5, 900)}${kept(7, 800)}`);
  await ready(page);
  await until(async () => {
    const lengths = await page.locator('.measures .number').allTextContents();
    return lengths.length === 3 && lengths.slice(1).every((text) => /\d/.test(text));
  }, 'the other lengths');
  assert.match(await page.locator('.trouble').textContent(), /larger than the server allows/);
  await page.context().close();
});

test('a measure that is taken away is not waited for', async () => {
  const page = await newPage(browser);
  const held = await hold(page, '**/path**');
  let given = 0;
  page.on('requestfailed', (request) => { if (request.url().includes('/path')) given++; });
  await page.goto(`${service.url}#mesh=${plane}&kept=auto;1;5,0.3,0.3;900,0.3,0.3`);
  await ready(page);
  await until(() => held.waiting.length === 1, 'its question');
  await page.getByRole('button', { name: 'Remove measure A' }).click();
  await until(() => given === 1, 'its question is given up');
  assert.equal(await page.locator('.trouble').count(), 0);
  held.release();
  await page.context().close();
});

test('regions have crisp borders in whichever order their fields come', async () => {
  const more = '&from=9700,0.3,0.3&from=1000,0.3,0.3&show=regions&lines=0';
  const parts = { ofAll: /\/distance.*labels=(1|true)/, ofOne: /\/distance(?!.*labels=(1|true))/ };
  const seen = [];
  for (const [first, last] of [['ofOne', 'ofAll'], ['ofAll', 'ofOne']]) {
    const page = await newPage(browser, { reducedMotion: 'reduce' });
    const held = await hold(page, parts[last]);
    let came = 0;
    page.on('requestfinished', (request) => { if (parts[first].test(request.url())) came++; });
    await page.goto(`${service.url}#mesh=${plane}${more}`);
    await ready(page);
    await until(() => came === (first === 'ofOne' ? 2 : 1) && held.waiting.length > 0, 'the first fields');
    for (let turns = 0; turns < 5; turns++) await page.evaluate(() => new Promise((go) => setTimeout(go)));
    let later = 0;
    page.on('requestfinished', (request) => { if (parts[last].test(request.url())) later++; });
    held.release();
    await until(() => later === (last === 'ofOne' ? 2 : 1), 'the last fields');
    await page.waitForSelector('.legend:not([hidden])');
    seen.push(await settled(page));
    await page.context().close();
  }
  assert.ok(difference(...seen) < 1e-4, 'both pictures are the same');
});

for (const [what, pattern] of [['methods', '**/v1/methods'], ['list of meshes', /\/v1\/meshes\?/]]) {
  test(`a server that has no time for the ${what} at first answers all the same`, async () => {
    const page = await newPage(browser);
    let busy = true;
    await page.route(pattern, (route) => (busy ? problem(503, 'overloaded')(route) : route.continue()));
    await page.goto(`${service.url}#mesh=${plane}`);
    await ready(page);
    const trouble = page.locator('.trouble');
    await trouble.waitFor();
    busy = what !== 'methods';
    await page.mouse.click(430, 340);
    await page.waitForSelector('.legend:not([hidden])');
    await page.mouse.click(330, 250);
    await pathLength(page);
    assert.ok((await page.locator('.methods input').count()) > 1);
    busy = false;
    await trouble.getByRole('button', { name: 'Try again' }).click();
    await until(async () => (await page.locator('#mesh option').count()) > 2, 'the list');
    await page.context().close();
  });
}

for (const [what, pattern, ask] of [
  ['field', '**/distance**', (page) => place(page, '0')],
  ['mesh', '**/geometry**', (page) => page.selectOption('#mesh', hole)],
]) {
  test(`a ${what} that fails each time, though the server is there, is not asked for without end`, async () => {
    const page = await openMesh(browser, service, plane);
    let tries = 0;
    let broken = true;
    await page.route(pattern, (route) => {
      tries++;
      return broken ? route.abort('connectionreset') : route.continue();
    });
    await ask(page);
    const trouble = page.locator('.trouble');
    await trouble.waitFor();
    assert.match(await trouble.textContent(), /does not come through/);
    assert.ok(await page.locator('.banner').isHidden());
    const before = tries;
    broken = false;
    await trouble.getByRole('button', { name: 'Try again' }).click();
    await until(() => tries > before, 'another try');
    if (what === 'field') await until(() => legend(page), 'the field');
    else await until(async () => /one_hole/.test(await page.title()), 'the mesh');
    await page.context().close();
  });
}

test('a link without a mesh, or with none that could be, keeps the present one alive', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3');
  await until(() => legend(page), 'the field');
  for (const fragment of ['mesh=../../etc', '', 'from=9700,0.3,0.3&mesh=']) {
    await page.evaluate((text) => { location.hash = text; }, fragment);
    await until(async () => page.url().includes(`mesh=${plane}`), 'the mesh in the link');
    await page.keyboard.press('1');
    await page.mouse.click(430, 340);
    await until(() => legend(page), 'the field');
    assert.equal(await page.locator('#mesh').inputValue(), plane);
  }
  await page.context().close();
});

test('a mesh that was deleted elsewhere goes from the list, by a choice and by a deletion', async () => {
  const upload = async (name) => (await service.json(`/v1/meshes?name=${name}`, { method: 'POST', body: wavyMesh(name.length) })).id;
  const [one, other] = [await upload('gone.obj'), await upload('gone_too.obj')];
  const page = await openMesh(browser, service, one);
  const listed = (id) => page.locator(`#mesh option[value="${id}"]`).count();
  assert.equal((await listed(one)) + (await listed(other)), 2);
  for (const id of [one, other]) await fetch(new URL(`/v1/meshes/${id}`, service.url), { method: 'DELETE' });
  await page.selectOption('#mesh', other);
  await until(async () => (await listed(other)) === 0, 'the one that was chosen is not listed');
  assert.equal(await page.locator('#mesh').inputValue(), one);
  await page.getByRole('button', { name: 'Delete this mesh' }).click();
  await page.getByRole('button', { name: 'Delete', exact: true }).click();
  await until(async () => (await listed(one)) === 0, 'the one that was shown is not listed');
  await until(async () => /plane|sphere|saddle|terrain|torus/.test(await page.title()), 'another mesh');
  await page.context().close();
});

test('points of a link that the mesh does not have are left out, for good', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&to=999999,0.2,0.2&kept=auto;1;5,0.3,0.3;999999,0.3,0.3&kept=auto;1;5,0.3,0.3;900,0.3,0.3');
  await until(() => legend(page), 'the field');
  assert.match(await page.locator('.trouble').textContent(), /not on the mesh/);
  assert.equal(await page.locator('.measures li').count(), 1);
  assert.ok(await page.getByRole('button', { name: 'Undo' }).isDisabled(), 'there is nothing to undo');
  // The same of a link to the mesh that is shown.
  page.asked.length = 0;
  await page.getByRole('button', { name: 'Close this message' }).click();
  await page.keyboard.press('1'); // a source, in the place of the other
  await place(page, '0');
  await page.locator('#place:not([hidden])').waitFor();
  await page.evaluate((id) => { location.hash = `mesh=${id}&from=999999,0.3,0.3&to=5,0.3,0.3`; }, plane);
  await page.locator('.trouble').waitFor();
  assert.match(await page.locator('.trouble').textContent(), /not on the mesh/);
  assert.equal(await points(page), 1);
  assert.deepEqual(page.asked.filter((url) => url.includes('999999') && url.includes('/v1/')), [], 'the server is not asked for them');
  await page.context().close();
});

test('a link to another mesh says nothing of its points by the mesh before', async () => {
  const page = await openMesh(browser, service, plane);
  await page.keyboard.press('1'); // a source, in the place of the other
  await place(page, '0');
  const told = page.locator('#place');
  await until(() => told.isVisible(), 'the place');
  const held = await hold(page, '**/geometry**');
  await page.evaluate((id) => { location.hash = `mesh=${id}&from=900,0.3,0.3`; }, hole);
  await until(() => held.waiting.length > 0, 'the question for the mesh');
  assert.ok(await told.isHidden());
  held.release();
  await until(() => legend(page), 'the field');
  assert.ok(await told.isHidden());
  await page.context().close();
});

test('an upload that ends after points were placed leaves them, and offers its mesh', async () => {
  const page = await openMesh(browser, service, plane);
  const held = await hold(page, (url) => /\/v1\/meshes$/.test(url.pathname) && url.searchParams.has('name'));
  await drop(page, 'late.obj', wavyMesh(17));
  await until(() => held.waiting.length > 0, 'the upload');
  await place(page, '5');
  await place(page, '7777');
  const length = await pathLength(page);
  held.release();
  const remark = page.locator('.remark');
  await remark.waitFor();
  assert.match(await remark.textContent(), /late\.obj is here/);
  assert.equal(await page.textContent('#length'), length);
  assert.equal(await points(page), 2);
  await remark.getByRole('button', { name: 'Show it' }).click();
  await until(async () => /^late\.obj/.test(await page.title()), 'the mesh');
  assert.equal(await points(page), 0);
  await page.context().close();
});
