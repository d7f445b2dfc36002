// The numbering that the contract promises: a file's vertices and faces come from the
// server in the order in which three.js's loaders give them, value by value, so that a
// field can be put straight into a vertex attribute.
//
// Files of the test's own, the samples, and the public files in GEODESIC_SHARED, if that
// is there.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { basename, extname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { launch, newPage } from './browser.mjs';
import { Service } from './service.mjs';

const { GEODESIC_SHARED, VIEWER_SOURCES } = process.env;
const THREE = join(VIEWER_SOURCES, 'node_modules/three');
const ORIGIN = 'http://three.test/';
const TYPES = { '.js': 'text/javascript', '.wasm': 'application/wasm' };

const PAGE = `<!doctype html><script type="importmap">
  {"imports": {"three": "/build/three.module.js", "three/addons/": "/examples/jsm/"}}
</script><script type="module">
  import * as THREE from 'three';
  import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
  import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
  import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
  const draco = new DRACOLoader().setDecoderPath('/examples/jsm/libs/draco/');
  const gltf = new GLTFLoader().setDRACOLoader(draco).setMeshoptDecoder(MeshoptDecoder);

  /** What is drawn, in the loader's order: world positions, and corners of triangles. */
  function drawn(geometry, matrix, isTriangles, out) {
    const positions = geometry.getAttribute('position');
    const point = new THREE.Vector3();
    const first = out.positions.length / 3;
    for (let i = 0; i < positions.count; i++) {
      out.positions.push(...point.fromBufferAttribute(positions, i).applyMatrix4(matrix));
    }
    if (!isTriangles) return;
    const corners = geometry.index?.count ?? positions.count;
    for (let i = 0; i + 3 <= corners; i += 3) {
      for (let k = 0; k < 3; k++) out.faces.push(first + (geometry.index ? geometry.index.getX(i + k) : i + k));
    }
  }

  /** Numbers by the thousand cross over as text: as JSON they take minutes. */
  function packed({ positions, faces }) {
    const text = (array) => {
      const bytes = new Uint8Array(array.buffer);
      let letters = '';
      for (let i = 0; i < bytes.length; i += 8192) letters += String.fromCharCode(...bytes.subarray(i, i + 8192));
      return btoa(letters);
    };
    return { positions: text(Float64Array.from(positions)), faces: text(Uint32Array.from(faces)) };
  }

  window.load = async (kind, base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const out = { positions: [], faces: [] };
    if (kind === '.drc') {
      const geometry = await new Promise((resolve, reject) => draco.parse(bytes.buffer, resolve, reject));
      drawn(geometry, new THREE.Matrix4(), true, out);
      return packed(out);
    }
    const { scene } = await gltf.parseAsync(bytes.buffer, '');
    scene.updateMatrixWorld(true);
    scene.traverse((object) => {
      if (!object.geometry) return;
      for (let i = 0; i < (object.isInstancedMesh ? object.count : 1); i++) {
        const matrix = object.matrixWorld.clone();
        if (object.isInstancedMesh) {
          const instance = new THREE.Matrix4();
          object.getMatrixAt(i, instance);
          matrix.multiply(instance);
        }
        drawn(object.geometry, matrix, object.isMesh, out);
      }
    });
    return packed(out);
  };
</script>`;

let browser, page, service;
before(async () => {
  service = await new Service().start();
  browser = await launch();
  page = await newPage(browser);
  await page.route(`${ORIGIN}**`, async (route) => {
    const path = new URL(route.request().url()).pathname;
    if (path === '/') return route.fulfill({ contentType: 'text/html', body: PAGE });
    const body = await readFile(join(THREE, path)).catch(() => null);
    if (!body) return route.fulfill({ status: 404, body: '' });
    return route.fulfill({ contentType: TYPES[extname(path)] ?? 'text/plain', body });
  });
  await page.goto(ORIGIN);
  await page.waitForFunction(() => window.load);
});
after(async () => {
  await browser.close();
  await service.end();
});

/** The arrays of a frame: positions and faces as the server has them. */
async function geometry(mesh) {
  const reply = await fetch(new URL(`/v1/meshes/${mesh}/geometry?format=frame`, service.url));
  const frame = await reply.arrayBuffer();
  const header = new DataView(frame);
  const length = header.getUint32(8, true);
  const { arrays } = JSON.parse(Buffer.from(frame, 24, length).toString());
  const array = (name, of) => {
    const { dtype, offset, nbytes } = arrays.find((one) => one.name === name);
    return new of[dtype](frame, offset, nbytes / of[dtype].BYTES_PER_ELEMENT);
  };
  const kinds = { '<f8': Float64Array, '<f4': Float32Array, '<u4': Uint32Array };
  return { positions: array('positions', kinds), faces: array('triangles', kinds) };
}

/** Uploads the bytes, loads them in the page, and compares; tells how many vertices there were. */
async function compare(kind, bytes) {
  const sent = await fetch(new URL('/v1/meshes', service.url), { method: 'POST', body: bytes });
  const mesh = await sent.json();
  assert.ok(sent.ok, `the server: ${mesh.detail}`);
  const ours = await geometry(mesh.id);
  const loaded = await page.evaluate(
    ([called, text, patience]) =>
      Promise.race([
        window.load(called, text),
        new Promise((_, reject) => setTimeout(() => reject(new Error('the loader came to no end')), patience)),
      ]),
    [kind, bytes.toString('base64'), 20_000],
  );
  const array = (text, Kind) => new Kind(Uint8Array.from(Buffer.from(text, 'base64')).buffer);
  const theirs = { positions: array(loaded.positions, Float64Array), faces: array(loaded.faces, Uint32Array) };
  assert.equal(ours.positions.length, theirs.positions.length, 'as many vertices');
  const size = Math.max(...mesh.bbox.max.map((high, k) => high - mesh.bbox.min[k]));
  // An index in the way of equal values would be off by more than rounding of matrices.
  for (let i = 0; i < ours.positions.length; i++) {
    const off = Math.abs(ours.positions[i] - theirs.positions[i]);
    if (!(off <= 1e-6 * size)) assert.fail(`vertex ${Math.floor(i / 3)}: ${ours.positions[i]} is ${theirs.positions[i]} there`);
  }
  assert.equal(ours.faces.length, theirs.faces.length, 'as many faces');
  // Of vertices in one place the geometry's triangles name the first.
  const firstAt = new Map();
  const first = (vertex) => {
    const place = ours.positions.subarray(3 * vertex, 3 * vertex + 3).join();
    if (!firstAt.has(place)) firstAt.set(place, vertex);
    return firstAt.get(place);
  };
  for (let v = 0; v < ours.positions.length / 3; v++) first(v);
  for (let f = 0; f < ours.faces.length; f += 3) {
    // Strips and fans are expanded with other first corners, of the same triangle.
    const corners = (faces) => [faces[f], faces[f + 1], faces[f + 2]].map(first).sort((a, b) => a - b).join();
    if (corners(ours.faces) !== corners(theirs.faces)) {
      assert.fail(`face ${f / 3}: ${corners(ours.faces)} is ${corners(theirs.faces)} there`);
    }
  }
  return mesh.vertices;
}

/** A glTF with all that has a bearing on order: a tree, primitives, strips, points, quantised positions, mirrors. */
function tree() {
  const document = {
    asset: { version: '2.0' },
    extensionsUsed: ['KHR_mesh_quantization'],
    extensionsRequired: ['KHR_mesh_quantization'],
    accessors: [],
    bufferViews: [],
    buffers: [],
  };
  const accessor = (array, type, components, more = {}) => {
    const bytes = Buffer.from(array.buffer);
    document.bufferViews.push({ buffer: document.buffers.length, byteLength: bytes.length, ...(more.stride && { byteStride: more.stride }) });
    document.buffers.push({ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString('base64')}` });
    const count = (more.stride ? bytes.length / more.stride : array.length / components);
    document.accessors.push({
      bufferView: document.bufferViews.length - 1, componentType: type, count, type: components === 3 ? 'VEC3' : 'SCALAR',
      ...(more.normalized && { normalized: true }), ...(more.bounds && { min: more.bounds[0], max: more.bounds[1] }),
    });
    return document.accessors.length - 1;
  };
  const five = accessor(new Float32Array([0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0.5]), 5126, 3, { bounds: [[0, 0, 0], [2, 1, 0.5]] });
  const quantised = accessor(new Int16Array([0, 0, 0, 9, 32767, 0, 0, 9, 0, -32767, 0, 9]), 5122, 3,
    { stride: 8, normalized: true, bounds: [[0, -32767, 0], [32767, 0, 0]] });
  const some = accessor(new Uint8Array([4, 3, 2, 0, 1, 2]), 5121, 1);
  const all = accessor(new Uint16Array([0, 1, 2, 3, 4]), 5123, 1);
  const primitive = (position, mode, indices) => ({ attributes: { POSITION: position }, mode, ...(indices !== undefined && { indices }) });
  document.meshes = [
    { primitives: [primitive(five, 4, some), primitive(quantised, 4), primitive(five, 5, all)] },
    { primitives: [primitive(five, 0), primitive(five, 6, all)] },
  ];
  document.nodes = [
    { children: [2, 1], translation: [1, 2, 3], rotation: [0, 0.6, 0, 0.8] },
    { mesh: 0, scale: [-1, 2, 3], children: [3] },
    { mesh: 1, matrix: [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 2, 0, 5, 6, 7, 1] },
    { mesh: 0, translation: [0, 0, -4] },
    { mesh: 1 },
  ];
  document.scenes = [{ nodes: [4] }, { nodes: [0, 4] }];
  document.scene = 1;
  return Buffer.from(JSON.stringify(document));
}

test('nodes, primitives and vertices come in the order of GLTFLoader', async () => {
  assert.equal(await compare('.gltf', tree()), 10 + 13 + 13 + 10);
});

test('the samples come in the order of GLTFLoader and DRACOLoader', async () => {
  const { meshes } = await service.json('/v1/meshes');
  const kinds = new Set();
  for (const { id, format } of meshes.filter(({ vertices, format }) => vertices <= 10_000 && format !== 'gltf')) {
    const bytes = Buffer.from(await (await fetch(new URL(`/v1/meshes/${id}/source`, service.url))).arrayBuffer());
    await compare(`.${format}`, bytes);
    kinds.add(format);
  }
  assert.deepEqual([...kinds].sort(), ['drc', 'glb']);
});

test('public files come in the order of GLTFLoader and DRACOLoader', async (t) => {
  const corpora = GEODESIC_SHARED && join(GEODESIC_SHARED, 'corpora');
  const oracle = corpora && JSON.parse(await readFile(join(corpora, 'gltf-good.json'), 'utf8').catch(() => 'null'));
  if (!oracle) return t.skip('no folder of corpora; set GEODESIC_SHARED');
  // Instances, which the oracle does not count, come to millions in some.
  const isSmall = ({ triangles, gpuInstancingNodes }) => triangles > 0 && triangles < 10_000 && !gpuInstancingNodes;
  const files = Object.keys(oracle).filter((name) => isSmall(oracle[name]));
  const draco = JSON.parse(await readFile(join(corpora, 'drc-good.json'), 'utf8'));
  for (const { file, faces } of draco) if (faces > 0 && faces < 10_000) files.push(file);
  const unlike = [];
  let vertices = 0;
  let compared = 0;
  for (const name of files) {
    const bytes = await readFile(join(corpora, name));
    try {
      vertices += await compare(extname(name), bytes);
      compared++;
    } catch (error) {
      unlike.push(`${basename(name)}: ${error.message.split('\n')[0]}`);
    }
  }
  t.diagnostic(`${compared} files with ${vertices} vertices`);
  for (const line of unlike) t.diagnostic(line);
  assert.deepEqual(unlike, []);
});
