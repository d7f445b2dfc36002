// What goes into the page and out of it: dropped files, broken ones, links, exports.
import assert from 'node:assert/strict';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { drop, newPage, openMesh, pathLength, picture, ready, reload, until } from './browser.mjs';
import { boxOfWhatIsDrawn, difference, statistics } from './pixels.mjs';
import { served } from './served.mjs';
import { wavyMesh, wavyObj } from './wavy_mesh.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

test('a dropped file is uploaded and shown', async () => {
  const page = await openMesh(browser, service, plane);
  const was = await picture(page, '20-before-drop');
  await drop(page, 'waves.glb', wavyMesh(60));
  await until(async () => (await page.locator('#mesh option:checked').textContent()) === 'waves.glb', 'the file in the list');
  await ready(page);
  const now = await picture(page, '21-dropped');
  assert.ok(difference(was, now) > 0.02);
  assert.match(await page.textContent('.mesh-part .facts'), /3,600 vertices · 6,962 faces · 1 boundary/);
  // The same again is known by its digest: nothing is sent.
  const asked = page.asked.length;
  await page.selectOption('#mesh', plane);
  await ready(page);
  await drop(page, 'again.glb', wavyMesh(60));
  await until(async () => (await page.locator('#mesh option:checked').textContent()) === 'waves.glb', 'the mesh by the name that it has');
  await ready(page);
  assert.ok(page.asked.slice(asked).every((url) => !url.endsWith('/v1/meshes')), 'no second upload');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

/** A glTF of one triangle whose buffer is a file beside it. */
const GLTF = JSON.stringify({
  asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0, name: 'inside' }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
  buffers: [{ byteLength: 36, uri: 'scene.bin' }], bufferViews: [{ buffer: 0, byteLength: 36 }],
  accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [3, 4, 0] }],
});

test('several files: a glTF takes its buffers along, others come one by one', async () => {
  const page = await openMesh(browser, service, plane);
  const chosen = () => page.locator('#mesh option:checked').textContent();
  const buffer = Buffer.from(new Float32Array([0, 0, 0, 3, 0, 0, 0, 4, 0]).buffer);
  await drop(page, 'scene.bin', buffer, 'scene.gltf', GLTF, 'wood.png', 'no image');
  await until(async () => (await chosen()) === 'scene.gltf', 'the glTF');
  await ready(page);
  assert.match(await page.textContent('.mesh-part .facts'), /3 vertices · 1 face ·/);
  await drop(page, 'one.obj', wavyObj(12), 'two.obj', wavyObj(13), 'readme.md', 'words');
  await until(async () => (await chosen()) === 'one.obj', 'the first of them');
  await until(async () => (await page.locator('#mesh option').allTextContents()).includes('two.obj'), 'and the other in the list');
  assert.equal(await page.locator('.trouble').count(), 0);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a glTF without its buffers says which files it needs, and that they may come along', async () => {
  const page = await openMesh(browser, service, plane);
  const two = JSON.parse(GLTF);
  two.buffers.push({ byteLength: 4, uri: 'more%20data.bin' });
  two.bufferViews.push({ buffer: 1, byteLength: 4 });
  await drop(page, 'alone.gltf', JSON.stringify(two));
  const trouble = page.locator('.trouble');
  await trouble.waitFor();
  const told = await trouble.textContent();
  assert.match(told, /needs other files.*drop the \.gltf together with its files, or their folder/s);
  assert.match(told, /alone\.gltf: needs scene\.bin, more data\.bin/);
  assert.deepEqual(page.faults.filter((text) => !/Failed to load resource.*422/.test(text)), []);
  await page.context().close();
});

test('a mesh is read again in another way, and what is opened then, too', async () => {
  const page = await openMesh(browser, service, plane);
  const chosen = () => page.locator('#mesh option:checked').textContent();
  await drop(page, 'parts.obj', wavyObj(21));
  await until(async () => (await chosen()) === 'parts.obj', 'the mesh');
  await ready(page);
  await page.getByText('Import options').click();
  await page.getByLabel('Scale').fill('0.001');
  await page.getByLabel('Axis up in the file').selectOption('z');
  await picture(page, '29-import');
  await page.getByRole('button', { name: 'Read this mesh again' }).click();
  await until(async () => /^parts\.obj · (up z, scale 0\.001|scale 0\.001, up z)$/.test(await chosen()), 'the mesh in metres');
  await ready(page);
  assert.match(await page.textContent('.mesh-part .facts'), /0\.02000 × .* units · scaled by 0\.001 · z was up/);
  assert.ok(await page.getByLabel('Y up').isChecked(), 'it was turned');
  await drop(page, 'more.obj', wavyObj(22));
  await until(async () => (await chosen()).startsWith('more.obj · '), 'another one like this');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('an import option that is none is marked, and nothing is read; a mesh shows how it was read', async () => {
  const page = await openMesh(browser, service, plane);
  await drop(page, 'options.obj', wavyObj(27));
  await until(async () => (await page.locator('#mesh option:checked').textContent()) === 'options.obj', 'the mesh');
  await ready(page);
  await page.getByText('Import options').click();
  const again = page.getByRole('button', { name: 'Read this mesh again' });
  const [scale, weld] = [page.getByLabel('Scale'), page.getByLabel('Join vertices within')];
  for (const [field, wrong, allowed] of [
    ...['abc', '0', '-1', '1e400'].map((text) => [scale, text, /Scale: a number above 0/]),
    ...['-5', 'on'].map((text) => [weld, text, /Join vertices within: a distance from 0 on, or off/]),
  ]) {
    await field.fill(wrong);
    assert.match(await page.textContent('#import-said'), allowed);
    assert.equal(await field.getAttribute('aria-invalid'), 'true', wrong);
    assert.ok(await again.isDisabled());
    await field.fill('');
    assert.equal(await field.getAttribute('aria-invalid'), 'false');
  }
  await weld.fill('on');
  await drop(page, 'never.obj', wavyObj(28));
  await page.locator('.trouble').waitFor();
  assert.match(await page.textContent('.trouble'), /import option cannot be read/);
  assert.equal(await page.locator('#mesh option:checked').textContent(), 'options.obj');
  await weld.fill('off');
  await scale.fill('0,5');
  await again.click();
  await until(async () => /scale 0\.5/.test(await page.locator('#mesh option:checked').textContent()), 'half as large');
  await ready(page);
  await until(async () => decodeURIComponent(page.url()).includes('~'), 'the reading in the link');
  await reload(page);
  await ready(page);
  assert.deepEqual([await scale.inputValue(), await weld.inputValue()], ['0.5', 'off']);
  assert.ok(await scale.isVisible(), 'where it is not as usual, it is seen');
  await page.selectOption('#mesh', plane);
  await ready(page);
  await until(async () => (await scale.inputValue()) === '' && (await weld.inputValue()) === '', 'the usual');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a broken file is explained, and what was there stays', async () => {
  const page = await openMesh(browser, service, plane);
  const was = await picture(page, '22-before-broken');
  await drop(page, 'holiday.jpg', Buffer.from('this is no mesh'));
  const trouble = page.locator('.trouble');
  await trouble.waitFor();
  assert.match(await trouble.textContent(), /no mesh that the server can read.*\.glb.*holiday\.jpg/s);
  // Half a GLB is a mesh file, but a broken one: another text.
  const whole = wavyMesh(20);
  await trouble.getByRole('button', { name: 'Close this message' }).click();
  await drop(page, 'half.glb', whole.subarray(0, whole.length / 2));
  await trouble.waitFor();
  await picture(page, '23-broken');
  assert.match(await trouble.textContent(), /mesh in this file is broken.*half\.glb/s);
  await trouble.getByRole('button', { name: 'Close this message' }).click();
  assert.ok(difference(was, await picture(page, '24-after-broken')) < 0.001);
  assert.equal(await page.locator('#mesh option:checked').textContent().then((text) => text.startsWith('plane')), true);
  // The browser itself reports refused requests; the page has no other fault.
  assert.deepEqual(page.faults.filter((text) => !/Failed to load resource.*(415|422)/.test(text)), []);
  await page.context().close();
});

/** The page's address once it has not changed for a while: the link follows the view at rest. */
async function lastUrl(page) {
  for (let url = page.url(); ; url = page.url()) {
    await page.waitForTimeout(1500);
    await page.waitForSelector('body:not([data-link])');
    if (page.url() === url) return url;
  }
}

const POINTS = '&from=9700,0.3,0.3&via=4000,0.2,0.5&to=19000,0.25,0.25';

test('a link reproduces the mesh, the points, the method and the view', async () => {
  const page = await openMesh(browser, service, plane, `${POINTS}&method=fast_marching&refine=shortest&colours=turbo&lines=12`);
  const length = await pathLength(page);
  assert.equal(
    Number(length),
    Number(
      (
        await service.json(
          `/v1/meshes/${plane}/path?from=f:9700,0.3,0.3&via=f:4000,0.2,0.5&to=f:19000,0.25,0.25&method=fast_marching&refine=shortest`,
        )
      ).length.toPrecision(4),
    ),
  );
  // Turned by hand, so that the camera is in the link, too.
  await page.mouse.move(60, 60);
  await page.mouse.down();
  await page.mouse.move(180, 130, { steps: 8 });
  await page.mouse.up();
  const seen = await picture(page, '25-linked');
  const link = await lastUrl(page);
  assert.match(link, /camera=/);
  await reload(page);
  await ready(page);
  assert.equal(await pathLength(page), length);
  const again = await picture(page, '26-reloaded');
  assert.ok(difference(seen, again) < 0.01, `the same view: ${difference(seen, again)}`);
  assert.ok(await page.getByLabel('Fast marching').isChecked());
  assert.ok(await page.getByLabel('Turbo').isChecked());
  assert.ok(await page.getByLabel('Pull the path straight').isChecked());
  // Elsewhere it is the same, too.
  const other = await newPage(browser);
  await other.goto(link);
  await ready(other);
  assert.equal(await pathLength(other), length);
  assert.ok(difference(again, await picture(other, '27-elsewhere')) < 0.001);
  assert.deepEqual([...page.faults, ...other.faults], []);
  await page.context().close();
  await other.context().close();
});

test('a link to a mesh that is not there, or to points that are not on it, is explained', async () => {
  const page = await newPage(browser);
  await page.goto(`${service.url}#mesh=${'0'.repeat(64)}`);
  await ready(page, 'failed');
  assert.match(await page.locator('.trouble').textContent(), /not on the server.*Drop its file again/s);
  await page.selectOption('#mesh', plane);
  await ready(page);
  assert.equal(await page.locator('.trouble').count(), 0, 'what is over is not shown any more');
  await page.context().close();
  const other = await openMesh(browser, service, plane, '&from=999999,0.3,0.3');
  assert.match(await other.locator('.trouble').textContent(), /not on the mesh/);
  assert.deepEqual(other.faults, []);
  await other.context().close();
});

test('everything can be taken along, in the formats that others read', async () => {
  const page = await openMesh(browser, service, plane, POINTS);
  const length = Number(await pathLength(page));
  await page.keyboard.press('k');
  await page.getByText('Export', { exact: true }).click();
  const saved = async (button) => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: button }).click()]);
    return { name: download.suggestedFilename(), bytes: await readFile(await download.path()) };
  };
  const json = await saved('Path · JSON');
  assert.equal(json.name, 'plane.path.json');
  const path = JSON.parse(json.bytes);
  assert.equal(Number(path.length.toPrecision(4)), length);
  const csv = (await saved('Path · CSV')).bytes.toString().trim().split('\n');
  assert.equal(csv[0], 'x,y,z,distance,face,w0,w1,w2');
  assert.equal(csv.length, path.points.length + 1);
  assert.ok(Math.abs(Number(csv.at(-1).split(',')[3]) / path.length - 1) < 1e-9, 'its last distance is its length');
  const glb = (await saved('Path · GLB')).bytes;
  assert.equal(glb.subarray(0, 4).toString(), 'glTF');
  const document = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)));
  assert.equal(document.accessors[document.meshes[0].primitives[0].attributes.POSITION].count, path.points.length);
  const colours = await saved('Distance · GLB');
  assert.equal(colours.name, 'plane.field.glb');
  const coloured = JSON.parse(colours.bytes.subarray(20, 20 + colours.bytes.readUInt32LE(12)));
  assert.ok('COLOR_0' in coloured.meshes[0].primitives[0].attributes, 'the field is on it');
  const npy = (await saved('Field · NPY')).bytes;
  assert.equal(npy.subarray(1, 6).toString(), 'NUMPY');
  assert.match(npy.subarray(10, 10 + npy.readUInt16LE(8)).toString(), /'<f8'.*\(10000,\)/);
  const measures = (await saved('Save as CSV')).bytes.toString().trim().split('\n');
  assert.deepEqual(measures[1].split(',').slice(2), ['auto', 'shortest', '1']);
  const png = await saved('View · PNG');
  const seen = statistics(png.bytes);
  assert.deepEqual([seen.width, seen.height], [1200, 760]);
  assert.ok(seen.colourful > 0.1, 'the field is on the picture');
  const mesh = boxOfWhatIsDrawn(png.bytes, { bottom: 640 });
  assert.ok(Math.abs((mesh.left + mesh.right) / 2 - 600) < 12, `in the middle, not from ${mesh.left} to ${mesh.right}`);
  const scale = boxOfWhatIsDrawn(png.bytes, { left: 1030, top: 722, right: 1190, bottom: 740 });
  const long = scale.right - scale.left;
  assert.ok(long > 48 && long <= 122, `the scale's bar is ${long} pixels long`);
  const { VIEWER_PICTURES } = process.env;
  if (VIEWER_PICTURES) await writeFile(join(VIEWER_PICTURES, '28-exported.png'), png.bytes);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
