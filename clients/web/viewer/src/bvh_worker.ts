/**
 * Builds the bounding-volume hierarchy of a mesh apart from the page, which would stand
 * still for as long as that takes: a second for a million vertices.
 */
import { BufferAttribute, BufferGeometry } from 'three';
import { MeshBVH } from 'three-mesh-bvh';

export interface BvhOrder {
  readonly positions: Float32Array;
  readonly triangles: Uint32Array;
}

self.onmessage = ({ data }: MessageEvent<BvhOrder>) => {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(data.positions, 3));
  geometry.setIndex(new BufferAttribute(data.triangles, 1));
  // Indirect: the triangles keep their order, which is the file's.
  const bvh = new MeshBVH(geometry, { indirect: true });
  const packed = MeshBVH.serialize(bvh, { cloneBuffers: false }) as {
    roots: ArrayBuffer[];
    indirectBuffer: Uint32Array | Uint16Array;
    index: Uint32Array | null;
  };
  self.postMessage({ ...packed, index: null }, { transfer: [...packed.roots, packed.indirectBuffer.buffer] });
};
