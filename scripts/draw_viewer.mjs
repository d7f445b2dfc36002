// Draws docs/viewer.png: the page at / on the sample of hills, with a source, a target and the method that it
// has by itself; and docs/viewer_brush.png, viewer_costs.png and viewer_loop.png of its page in the guide.
// scripts/draw_viewer says how to run it.
import { writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { launch, openMesh, pathLength, settled, textAt } from '../tests/clients/viewer/browser.mjs';
import { Service } from '../tests/clients/viewer/service.mjs';

const SIZE = { width: 1280, height: 800 };
const SMALL = { width: 1120, height: 700 };
// Where strokes of the brush begin, on the page.
const LAKE = [[410, 430], [400, 462], [415, 495]];
// Places of the map, which is seen from the south and well above: y points up, and z to the south.
const [SOURCE, TARGET] = ['55,58', '140,48'];
const CAMERA = '-0.5,2.4,2.1,0,0,0';

/** The point of the ground below a place of the map, as a link of the viewer says it. */
async function spot(service, mesh, place) {
  const [east, north] = place.split(',');
  const { points } = await service.json(`/v1/meshes/${mesh}/nearest?point=ray:${east},500,-${north},0,-1,0`);
  const { face, bary } = points[0];
  return [face, bary[0], bary[1]].join();
}

/** The picture as a PNG. */
export async function drawViewer(browser, service) {
  const mesh = await service.sample('terrain');
  const [from, to] = await Promise.all([SOURCE, TARGET].map((place) => spot(service, mesh, place)));
  const page = await openMesh(browser, service, mesh, `&camera=${CAMERA}&from=${from}&to=${to}`, { viewport: SIZE });
  await pathLength(page);
  await settled(page);
  const picture = await page.screenshot();
  await page.context().close();
  return picture;
}

/** A lake is painted, and the way keeps to its shore. */
export async function drawBrush(browser, service) {
  const mesh = await service.sample('terrain');
  const [from, to] = await Promise.all([SOURCE, TARGET].map((place) => spot(service, mesh, place)));
  const page = await openMesh(browser, service, mesh, `&camera=${CAMERA}&from=${from}&to=${to}`, { viewport: SMALL });
  const straight = await pathLength(page);
  await paint(page);
  await pathLength(page, straight);
  return takenOf(page);
}

async function paint(page) {
  await page.getByLabel('Brush', { exact: true }).check();
  for (const [x, y] of LAKE) {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y, { steps: 6 });
    await page.mouse.up();
  }
}

/** The quickest way on foot, and ground with a weight. */
export async function drawCosts(browser, service) {
  const mesh = await service.sample('terrain');
  const [from, to] = await Promise.all([SOURCE, TARGET].map((place) => spot(service, mesh, place)));
  const page = await openMesh(browser, service, mesh, `&camera=${CAMERA}&from=${from}&to=${to}&walking=tobler,y`, { viewport: SMALL });
  const before = await pathLength(page);
  await page.getByLabel('Brush', { exact: true }).check();
  await page.getByRole('radio', { name: 'Weighted' }).check();
  await paint(page);
  await pathLength(page, before);
  await page.locator('.result:not(.stale)').waitFor({ state: 'attached' });
  return takenOf(page);
}

/** The girth of a strand of the knot, and a tape round it. */
export async function drawLoop(browser, service) {
  const mesh = await service.sample('torus_knot');
  const { points } = await service.json(`/v1/meshes/${mesh}/nearest?point=ray:0.8,-0.6,9,0,0,-1`);
  const { face, bary } = points[0];
  const page = await openMesh(browser, service, mesh, `&loop=plane;1,1,0;${face},${bary[0]},${bary[1]}`, { viewport: SMALL });
  await page.getByLabel('Loop', { exact: true }).check();
  await textAt(page, '#round', (text) => /\d/.test(text));
  return takenOf(page);
}

async function takenOf(page) {
  await page.mouse.move(5, 5);
  await settled(page);
  const picture = await page.screenshot();
  await page.context().close();
  return picture;
}

const [, script, file] = process.argv;
if (fileURLToPath(import.meta.url) === script) {
  const service = await new Service().start();
  const browser = await launch({ smooth: true });
  try {
    await writeFile(file, await drawViewer(browser, service));
    await writeFile(join(dirname(file), 'viewer_brush.png'), await drawBrush(browser, service));
    await writeFile(join(dirname(file), 'viewer_costs.png'), await drawCosts(browser, service));
    await writeFile(join(dirname(file), 'viewer_loop.png'), await drawLoop(browser, service));
  } finally {
    await browser.close();
    await service.end();
  }
}
