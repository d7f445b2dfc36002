/** The helpers for three.js, on what a real server answers. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { BufferAttribute, BufferGeometry } from 'three';
import { isolinesToSegments, pathToLine, setField, verticesOf } from 'geodesicd-client/three';
import { fixture } from './fixture.js';

const { client, plane } = await fixture();

async function planeGeometry(): Promise<BufferGeometry> {
  const { positions, triangles } = await client.geometry(plane);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setIndex(new BufferAttribute(triangles, 1));
  return geometry;
}

test('a field on a geometry, and the next in its place', async () => {
  const geometry = await planeGeometry();
  const first = await client.distance(plane, { from: 0 });
  const second = await client.distance(plane, { from: 9999 }, { values: 'f64' });
  const attribute = setField(geometry, first.values);
  assert.equal(geometry.getAttribute('field'), attribute);
  assert.equal(attribute.getX(99), 99);
  const version = attribute.version;
  assert.equal(setField(geometry, second.values), attribute);
  assert.ok(attribute.version > version, 'the GPU is not told');
  assert.equal(attribute.getX(9999), 0);
  assert.equal(first.values[0], 0, 'the first field was written over');
});

test('labels beside a field; a field of another mesh is refused', async () => {
  const geometry = await planeGeometry();
  const { values, labels } = await client.distance(plane, { from: [0, 99], labels: true });
  setField(geometry, values);
  const attribute = setField(geometry, labels!, 'label');
  assert.ok(attribute.array instanceof Uint32Array);
  assert.equal(attribute.getX(99), 1);
  assert.throws(() => setField(geometry, values.subarray(1)), RangeError);
  assert.throws(() => setField(new BufferGeometry(), values), RangeError);
});

test("a part's own vertices", async () => {
  const { parts } = await client.mesh(plane);
  const { values } = await client.distance(plane, { from: 0 });
  const part = { ...parts[0]!, first_vertex: 100, vertex_count: 50 };
  const slice = verticesOf(values, part);
  assert.equal(slice.length, 50);
  assert.equal(slice.buffer, values.buffer);
  assert.equal(slice[0], values[100]);
  const { positions } = await client.geometry(plane);
  assert.deepEqual([...verticesOf(positions, part, 3).subarray(0, 3)], [0, 1, 0]);
});

test('a path as a line, however it was fetched', async () => {
  const query = { from: 0, to: 2 } as const;
  const expected = [0, 0, 0, 1, 0, 0, 2, 0, 0];
  const path = await client.path(plane, query);
  const frame = await client.frame(plane, { of: 'path', ...query });
  const array = await client.array(plane, { of: 'path', format: 'f32', ...query });
  for (const line of [path, frame, array.data as Float32Array, path.points.map(({ xyz }) => xyz)]) {
    const { geometry } = pathToLine(line);
    assert.deepEqual([...geometry.getAttribute('position').array], expected);
  }
  assert.equal(pathToLine({ points: [] }).geometry.getAttribute('position').count, 0);
});

test('isolines as segments: as long as the server says, closed where they are', async () => {
  const reply = await client.isolines(plane, { from: 5050, levels: [10, 60] });
  const { geometry } = isolinesToSegments(reply);
  const position = geometry.getAttribute('position') as BufferAttribute;
  const level = geometry.getAttribute('level') as BufferAttribute;
  assert.ok(reply.isolines.some(({ closed }) => closed));
  for (const wanted of [10, 60]) {
    let length = 0;
    for (let i = 0; i < position.count; i += 2) {
      if (level.getX(i) !== wanted) continue;
      length += Math.hypot(position.getX(i + 1) - position.getX(i), position.getY(i + 1) - position.getY(i));
    }
    const told = reply.isolines.filter((line) => line.level === wanted);
    const sum = told.reduce((all, line) => all + line.length, 0);
    assert.ok(sum > 0 && Math.abs(length - sum) < 1e-4 * sum, `${length} is not ${sum}`);
  }
});
