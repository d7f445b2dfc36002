// What meshes are called: the server's names, for every browser alike; renamed and deleted.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { drop, newPage, openMesh, picture, ready, reload, until } from './browser.mjs';
import { proxied } from './proxy.mjs';
import { served } from './served.mjs';
import { started } from './service.mjs';
import { wavyMesh, wavyObj } from './wavy_mesh.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const chosen = (page) => page.locator('#mesh option:checked').textContent();
const names = (page) => page.locator('#mesh option').allTextContents();
const upload = async (body, query = '', to = service) =>
  (await (await fetch(`${to.url}v1/meshes${query}`, { method: 'POST', body })).json()).id;
const isCalled = (page, name) => until(async () => (await chosen(page)) === name, `the name ${name}`);

test('a dropped file’s name is the server’s, and every browser shows it', async () => {
  const page = await openMesh(browser, service, plane);
  const name = 'Höhe & Weite; 100 % "球".glb';
  await drop(page, name, wavyMesh(31));
  await isCalled(page, name);
  await ready(page);
  assert.equal(await page.title(), `${name} · geodesicd`);
  const id = await until(async () => {
    const linked = new URLSearchParams(new URL(page.url()).hash.slice(1)).get('mesh');
    return linked !== plane && linked;
  }, 'the link to it');
  assert.equal((await service.json(`/v1/meshes/${id}`)).name, name);
  const other = await openMesh(browser, service, id);
  assert.equal(await chosen(other), name);
  assert.deepEqual([...page.faults, ...other.faults], []);
  await page.context().close();
  await other.context().close();
});

test('a mesh without a name is called by what is in its file, else by its id; dropped again, by the file', async () => {
  const bare = await upload(wavyObj(14));
  const named = await upload(wavyMesh(32));
  const { parts } = await service.json(`/v1/meshes/${named}`);
  const page = await openMesh(browser, service, bare);
  assert.equal(await chosen(page), `unnamed ${bare.slice(0, 6)}`);
  await page.selectOption('#mesh', named);
  await ready(page);
  assert.equal(await chosen(page), parts[0].name.replaceAll('_', ' ') || `unnamed ${named.slice(0, 6)}`);
  await drop(page, 'late.obj', wavyObj(14));
  await isCalled(page, 'late.obj');
  assert.equal((await service.json(`/v1/meshes/${bare}`)).name, 'late.obj');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('readings of one file and equal names are told apart in the list', async () => {
  const bytes = wavyObj(15);
  const readings = ['', '&scale=0.001', '&scale=0.001&up=z', '&weld=off'];
  for (const reading of readings) await upload(bytes, `?name=twice.obj${reading}`);
  await upload(wavyObj(16), '?name=same.obj');
  await upload(wavyObj(17), '?name=same.obj');
  const page = await openMesh(browser, service, plane);
  const listed = await names(page);
  assert.equal(new Set(listed).size, listed.length, 'no two are the same');
  for (const how of ['', ' · scale 0.001', ' · weld off']) assert.ok(listed.includes(`twice.obj${how}`), how);
  assert.equal(listed.filter((name) => name.startsWith('twice.obj')).length, readings.length);
  assert.equal(listed.filter((name) => /^same\.obj · \d+ · [0-9a-f]{4}$/.test(name)).length, 2);
  assert.deepEqual(listed, [...listed].sort((a, b) => a.localeCompare(b)));
  await page.context().close();
});

test('a link may name its mesh; a name that none has, or several, is told', async () => {
  const id = await upload(wavyObj(24), '?name=named.obj');
  await upload(wavyObj(25), '?name=pair.obj');
  await upload(wavyObj(26), '?name=pair.obj');
  const page = await newPage(browser);
  await page.goto(`${service.url}#mesh=named.obj&from=v:7`);
  await ready(page);
  assert.equal(await chosen(page), 'named.obj');
  await until(async () => page.url().includes(id), 'its id in the link');
  assert.equal(await page.locator('.point').count(), 1);
  for (const [name, told] of [['nobody.glb', /No mesh has this name.*nobody\.glb/s], ['pair.obj', /2 meshes have this name.*pair\.obj/s]]) {
    await page.evaluate((hash) => { location.hash = hash; }, `#mesh=${name}`);
    await until(async () => told.test(await page.locator('.troubles').textContent()), name);
    await until(async () => page.url().includes(id), 'what is shown stays in the address');
    assert.equal(await chosen(page), 'named.obj');
    const other = await newPage(browser);
    await other.goto(`${service.url}#mesh=${name}`);
    await ready(other, 'failed');
    assert.match(await other.locator('.trouble').textContent(), told);
    await other.selectOption('#mesh', id);
    await ready(other);
    assert.deepEqual(other.faults, []);
    await other.context().close();
  }
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a link may name a mesh that the list is too long to show', async (t) => {
  const own = await started(t);
  const headers = { 'Content-Type': 'model/obj' };
  for (let at = 0; at < 210; at++) {
    const body = `v 0 0 0\nv ${at + 1} 0 0\nv 0 1 0\nf 1 2 3\n`;
    await own.json(`/v1/meshes?name=many-${at}`, { method: 'POST', body, headers });
  }
  const listed = new Set((await own.json('/v1/meshes?limit=200')).meshes.map(({ name }) => name));
  const beyond = Array.from({ length: 210 }, (_, at) => `many-${at}`).find((name) => !listed.has(name));
  const page = await newPage(browser);
  await page.goto(`${own.url}#mesh=${beyond}`);
  await ready(page);
  await until(async () => (await page.title()).startsWith(beyond), 'the mesh');
  await page.goto(`${own.url}#mesh=no-such-name`);
  await until(async () => /No mesh has this name/.test(await page.locator('.troubles').textContent()), 'told');
  assert.ok((await page.title()).startsWith(beyond), 'what was there stays');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a mesh is renamed, and loses its name again', async () => {
  const id = await upload(wavyObj(18), '?name=first.obj');
  const page = await openMesh(browser, service, id);
  const rename = async (name) => {
    await page.getByRole('button', { name: 'Rename this mesh' }).click();
    await page.getByLabel(/^Name;/).fill(name);
    await page.getByRole('button', { name: 'Rename', exact: true }).click();
  };
  await page.getByRole('button', { name: 'Rename this mesh' }).click();
  await picture(page, '71-rename');
  await page.getByRole('button', { name: 'Cancel' }).click();
  assert.equal(await page.locator('dialog[open]').count(), 0);
  await rename('  Second & last ');
  await isCalled(page, 'Second & last');
  assert.equal(await page.title(), 'Second & last · geodesicd');
  assert.equal((await service.json(`/v1/meshes/${id}`)).name, 'Second & last');
  await rename('');
  await isCalled(page, `unnamed ${id.slice(0, 6)}`);
  assert.equal((await service.json(`/v1/meshes/${id}`)).name, undefined);
  // What the server would not take for its length stays to be mended: 200 characters of three bytes.
  await rename('球'.repeat(200));
  assert.match(await page.getByLabel(/^Name;/).evaluate((line) => line.validationMessage), /200 bytes/);
  // What else it does not take is told, and the name stays.
  await page.getByLabel(/^Name;/).fill('turned \u202e about');
  await page.getByRole('button', { name: 'Rename', exact: true }).click();
  await page.locator('.trouble').waitFor();
  assert.equal(await chosen(page), `unnamed ${id.slice(0, 6)}`);
  assert.deepEqual(page.faults.filter((text) => !/Failed to load resource.*400/.test(text)), []);
  await page.context().close();
});

test('a mesh is deleted after a question, and another is shown; at last none', async (t) => {
  const own = await started(t);
  const page = await openMesh(browser, own, await upload(wavyObj(19), '?name=doomed.obj', own));
  await page.mouse.click(430, 380);
  const remove = async (answer) => {
    await page.getByRole('button', { name: 'Delete this mesh' }).click();
    await page.getByRole('button', { name: answer, exact: true }).click();
  };
  const count = async () => (await own.json('/v1/meshes')).meshes.length;
  const before = await count();
  await page.getByRole('button', { name: 'Delete this mesh' }).click();
  await picture(page, '72-delete');
  // Enter by itself deletes nothing.
  await page.keyboard.press('Enter');
  assert.equal(await page.locator('dialog[open]').count(), 0);
  assert.equal(await count(), before);
  await remove('Cancel');
  assert.equal(await count(), before);
  await remove('Delete');
  await until(async () => (await count()) === before - 1, 'it is gone');
  await until(async () => !(await names(page)).includes('doomed.obj'), 'from the list, too');
  await ready(page);
  assert.equal(await page.locator('.point').count(), 0);
  for (const { id } of (await own.json('/v1/meshes')).meshes) {
    await page.selectOption('#mesh', id);
    await ready(page);
    if ((await count()) > 1) await fetch(`${own.url}v1/meshes/${id}`, { method: 'DELETE' });
  }
  const [{ id: last }] = (await own.json('/v1/meshes')).meshes;
  await until(async () => page.url().includes(last), 'the link to the last');
  // Those that somebody else deleted are known to be gone once the page is loaded again.
  await reload(page);
  await ready(page);
  assert.equal((await names(page)).length, 1);
  await remove('Delete');
  await ready(page, 'empty');
  await picture(page, '73-no-mesh-left');
  assert.equal(await page.getByRole('button', { name: 'Delete this mesh' }).isVisible(), false);
  assert.equal(await page.title(), 'geodesicd');
  await drop(page, 'next.obj', wavyObj(20));
  await ready(page);
  assert.equal(await chosen(page), 'next.obj');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('who may not delete is told what the server says, and the mesh stays', async (t) => {
  const made = execFileSync(process.env.GEODESICD, ['--make-token', 'ann', '--scopes', 'read,upload'], { encoding: 'utf8' });
  const [token, line] = made.trim().split('\n');
  const folder = mkdtempSync(join(tmpdir(), 'viewer_'));
  writeFileSync(join(folder, 'tokens'), `${line}\n`);
  const own = await started(t, '--tokens', join(folder, 'tokens'));
  const page = await newPage(browser);
  await page.goto(own.url);
  await page.getByRole('button', { name: 'Enter a token' }).click();
  await page.locator('dialog input').fill(token);
  await page.getByRole('button', { name: 'Use it' }).click();
  await ready(page);
  const before = await chosen(page);
  await page.getByRole('button', { name: 'Delete this mesh' }).click();
  await page.getByRole('button', { name: 'Delete', exact: true }).click();
  await page.locator('.trouble').waitFor();
  assert.match(await page.textContent('.trouble'), /not allowed.*scope 'admin'/is);
  assert.equal(await chosen(page), before);
  await page.context().close();
  rmSync(folder, { recursive: true });
});

test('a page of another origin may look, and is told that it may not rename', async () => {
  const proxy = await proxied(service, { host: 'meshes.example' });
  const page = await openMesh(browser, proxy, plane);
  const before = await chosen(page);
  await page.getByRole('button', { name: 'Rename this mesh' }).click();
  await page.getByLabel(/^Name;/).fill('taken over');
  await page.getByRole('button', { name: 'Rename', exact: true }).click();
  await page.locator('.trouble').waitFor();
  await picture(page, '74-not-allowed');
  assert.match(await page.textContent('.trouble'), /not allowed.*origin/is);
  assert.equal(await chosen(page), before);
  assert.equal((await service.json(`/v1/meshes/${plane}`)).name, before);
  await page.context().close();
});
