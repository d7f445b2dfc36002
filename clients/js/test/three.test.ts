/** The helpers for three.js, on what a real server answers. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { BufferAttribute, BufferGeometry, type Mesh } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { isolinesToSegments, logmapToDecal, pathToLine, setField, verticesOf } from 'geodesicd-client/three';
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

/** Of each triangle its corners' vertices. */
function facesOf(geometry: BufferGeometry): number[][] {
  const corners = [...geometry.index!.array];
  return Array.from({ length: corners.length / 3 }, (_, face) => corners.slice(3 * face, 3 * face + 3));
}

test('a map as a decal: its faces, upright, and the geometry as it was', async () => {
  const geometry = await planeGeometry();
  const before = facesOf(geometry).length;
  const map = await client.logmap(plane, { from: 0, radius: 2 });
  const decal = logmapToDecal(geometry, map);
  const uv = decal.getAttribute('uv') as BufferAttribute;
  assert.deepEqual([...map.vertices], [0, 1, 2, 100, 101, 200]);
  const expected = { 0: [0.5, 0.5], 2: [1, 0.5], 101: [0.75, 0.75], 200: [0.5, 1], 3: [-1, -1] };
  for (const [vertex, [u, v]] of Object.entries(expected)) {
    const found = [uv.getX(Number(vertex)), uv.getY(Number(vertex))];
    assert.ok(Math.hypot(found[0]! - u!, found[1]! - v!) < 1e-6, `${vertex} is at ${found}`);
  }
  // Of the square in the corner both faces, and of its two neighbours those with all corners placed.
  const faces = facesOf(decal);
  assert.deepEqual(faces, facesOf(geometry).filter((face) => face.every((vertex) => map.vertices.includes(vertex))));
  assert.ok(faces.length >= 2 && faces.length <= 4, `${faces.length} faces`);
  assert.equal(decal.getAttribute('position'), geometry.getAttribute('position'));
  assert.equal(geometry.getAttribute('uv'), undefined);
  assert.equal(facesOf(geometry).length, before);
  const wide = logmapToDecal(geometry, map, { size: 8 }).getAttribute('uv');
  assert.equal(wide.getX(2), 0.75);
});

test('a decal on one part, on a geometry without an index, and on none that it fits', async () => {
  const geometry = await planeGeometry();
  const map = await client.logmap(plane, { from: 250, radius: 3 });
  const whole = facesOf(logmapToDecal(geometry, map));
  const [first] = (await client.mesh(plane)).parts;
  const part = { ...first!, first_vertex: 100, vertex_count: 9900 };
  const positions = geometry.getAttribute('position').array.slice(300);
  const lower = new BufferGeometry().setAttribute('position', new BufferAttribute(positions, 3));
  const within = (faces: number[][]) =>
    faces.filter((face) => Math.min(...face) >= 100).map((face) => face.map((vertex) => vertex - 100));
  lower.setIndex(within(facesOf(geometry)).flat());
  const decal = logmapToDecal(lower, map, { part });
  const uv = decal.getAttribute('uv');
  assert.deepEqual([uv.getX(150), uv.getY(150)], [0.5, 0.5]);
  assert.deepEqual(facesOf(decal), within(whole));
  assert.ok(decal.index!.count > 0 && within(whole).length < whole.length);

  const places = { radius: 1, vertices: new Uint32Array([0, 1, 2, 3, 4]), coordinates: new Float64Array(10) };
  const loose = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(18), 3));
  assert.deepEqual(facesOf(logmapToDecal(loose, places)), [[0, 1, 2]]);

  assert.throws(() => logmapToDecal(loose, map), RangeError);
  assert.throws(() => logmapToDecal(geometry, map, { part }), RangeError);
  assert.throws(() => logmapToDecal(new BufferGeometry(), map), RangeError);
});

test('a map of the point alone is a decal without faces', async () => {
  const map = await client.logmap(plane, { from: 5050, radius: 0.5 });
  assert.equal(logmapToDecal(await planeGeometry(), map).index!.count, 0);
});

test('a decal has the faces and, v turned over, the texture coordinates of the server’s GLB', async () => {
  const query = { from: 5050, radius: 4, angle: 0.5 };
  const glb = await client.glb(plane, { of: 'logmap', ...query });
  const { scene } = await new GLTFLoader().parseAsync(glb, '');
  const drawn = (scene.getObjectByProperty('isMesh', true) as Mesh).geometry;
  const map = await client.logmap(plane, query);
  const decal = logmapToDecal(await planeGeometry(), map);
  assert.equal(decal.index!.count, drawn.index!.count);
  const [uv, theirs] = [decal.getAttribute('uv'), drawn.getAttribute('uv')];
  map.vertices.forEach((vertex, place) => {
    const apart = Math.hypot(uv.getX(vertex) - theirs.getX(place), uv.getY(vertex) - (1 - theirs.getY(place)));
    assert.ok(apart < 1e-6, `${vertex} is ${apart} off`);
  });
});
