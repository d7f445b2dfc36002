// A mesh of any size as a GLB: a square whose height is a few waves, so that exact methods
// have much to do on it.

/** `side` times `side` vertices, one unit apart. */
export function wavyMesh(side) {
  const positions = new Float32Array(3 * side * side);
  for (let y = 0; y < side; y++) {
    for (let x = 0; x < side; x++) {
      const height = 6 * Math.sin(x / 9) * Math.cos(y / 11) + 2 * Math.sin((x + y) / 4);
      positions.set([x, y, height], 3 * (y * side + x));
    }
  }
  const triangles = new Uint32Array(6 * (side - 1) ** 2);
  let at = 0;
  for (let y = 0; y + 1 < side; y++) {
    for (let x = 0; x + 1 < side; x++) {
      const a = y * side + x;
      triangles.set([a, a + 1, a + side, a + 1, a + side + 1, a + side], at);
      at += 6;
    }
  }
  return glbOf(positions, triangles, [side - 1, side - 1, 8]);
}

function glbOf(positions, triangles, most) {
  const bytes = positions.byteLength + triangles.byteLength;
  const document = {
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, name: 'waves' }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    buffers: [{ byteLength: bytes }],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: positions.byteLength },
      { buffer: 0, byteOffset: positions.byteLength, byteLength: triangles.byteLength },
    ],
    accessors: [
      { bufferView: 0, componentType: 5126, count: positions.length / 3, type: 'VEC3', min: [0, 0, -8], max: most },
      { bufferView: 1, componentType: 5125, count: triangles.length, type: 'SCALAR' },
    ],
  };
  const json = Buffer.from(JSON.stringify(document).padEnd(Math.ceil(JSON.stringify(document).length / 4) * 4));
  const head = Buffer.alloc(20);
  head.write('glTF');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(28 + json.length + bytes, 8);
  head.writeUInt32LE(json.length, 12);
  head.write('JSON', 16);
  const chunk = Buffer.alloc(8);
  chunk.writeUInt32LE(bytes, 0);
  chunk.write('BIN\0', 4);
  return Buffer.concat([head, json, chunk, Buffer.from(positions.buffer), Buffer.from(triangles.buffer)]);
}

/** The same shape as an OBJ, which does not say what is up. */
export function wavyObj(side) {
  const lines = [];
  for (let y = 0; y < side; y++) {
    for (let x = 0; x < side; x++) lines.push(`v ${x} ${y} ${6 * Math.sin(x / 9) * Math.cos(y / 11)}`);
  }
  for (let y = 0; y + 1 < side; y++) {
    for (let x = 1; x < side; x++) {
      const a = y * side + x;
      lines.push(`f ${a} ${a + 1} ${a + side}`, `f ${a + 1} ${a + side + 1} ${a + side}`);
    }
  }
  return lines.join('\n');
}
