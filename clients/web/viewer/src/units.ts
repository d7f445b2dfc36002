/** What a length of a mesh is in: glTF says metres; other formats do not say. */
import type { MeshMetadata } from 'geodesicd-client';

export function unitOf({ format, import: reading }: MeshMetadata): string {
  return (format === 'glb' || format === 'gltf') && reading.scale === undefined ? 'm' : 'units';
}
