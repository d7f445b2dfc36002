/**
 * Which axis of a mesh is up. glTF says y, and is believed; so is an upload that was told
 * which. Other formats do not say: what the reader chose last, else a guess by the shape.
 */
import type { MeshMetadata } from 'geodesicd-client';
import type { Axis } from './state.ts';
import { Kept } from './storage.ts';

const KEPT = new Kept('localStorage', 'geodesicd-up');

/** Whether the file itself settles it. */
export function saysUp({ format, import: reading }: MeshMetadata): boolean {
  return format === 'glb' || format === 'gltf' || reading.up !== undefined;
}

export function upOf(about: MeshMetadata): Axis {
  if (saysUp(about)) return 'y';
  const kept = KEPT.value;
  if (kept === 'x' || kept === 'y' || kept === 'z') return kept;
  const [x, y, z] = [0, 1, 2].map((axis) => about.bbox.max[axis]! - about.bbox.min[axis]!) as [number, number, number];
  const flat = z < 0.02 * Math.max(x, y);
  // What is much lower in z than wide is a terrain.
  return z < 0.75 * Math.min(x, y) && !flat ? 'z' : 'y';
}

/** Remembers a choice for files that do not say. */
export function rememberUp(about: MeshMetadata, axis: Axis): void {
  if (!saysUp(about)) KEPT.value = axis;
}
