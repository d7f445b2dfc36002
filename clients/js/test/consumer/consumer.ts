/**
 * A stranger's use of the installed package, compiled with their strictest settings and
 * run by Node. Prints what it found as JSON. usage: consumer.js ADDRESS MESH-FILE
 */
import { readFile } from 'node:fs/promises';
import { GeodesicClient, GeodesicError, NetworkError, type Field, type Path } from 'geodesicd-client';

const [, , address, file] = process.argv;
const client = new GeodesicClient(address, { retries: 0 });
const mesh = await client.upload(await readFile(file as string));
const field: Field = await client.distance(mesh.id, { from: 'v:0', method: 'exact' });
const values: Float32Array = field.values;
const wide: Float64Array = (await client.distance(mesh.id, { from: 0 }, { values: 'f64' })).values;
const path: Path = await client.job(mesh.id, { query: 'path', from: 0, to: { xyz: [9, 0, 1] } });
const codes: string[] = [];
await client.path(mesh.id, { from: 0, to: -1 }).catch((error: unknown) => {
  if (error instanceof GeodesicError) codes.push(error.code);
});
await new GeodesicClient('http://127.0.0.1:9', { retries: 0 }).status().catch((error: unknown) => {
  if (error instanceof NetworkError) codes.push(error.name);
});
console.log(
  JSON.stringify({ vertices: values.length, wide: wide.length, length: path.length, codes }),
);
