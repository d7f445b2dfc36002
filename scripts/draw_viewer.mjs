// Draws docs/viewer.png: the page at / on the sample of hills, with a source, a target and the method that it
// has by itself. scripts/draw_viewer says how to run it.
import { writeFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { launch, openMesh, pathLength, settled } from '../tests/clients/viewer/browser.mjs';
import { Service } from '../tests/clients/viewer/service.mjs';

const SIZE = { width: 1280, height: 800 };
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

const [, script, file] = process.argv;
if (fileURLToPath(import.meta.url) === script) {
  const service = await new Service().start();
  const browser = await launch({ smooth: true });
  try {
    await writeFile(file, await drawViewer(browser, service));
  } finally {
    await browser.close();
    await service.end();
  }
}
