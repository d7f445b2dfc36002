/** What meshes are called on the page: as the server knows them, else by what is in the file. */
import type { MeshMetadata } from 'geodesicd-client';
import { countText } from './numbers.ts';

/** The mesh's own name, else that of its first part with one, else the beginning of its id. */
export function meshName({ id, name, parts }: MeshMetadata): string {
  if (name) return name;
  const named = parts.find((part) => part.name)?.name;
  return named ? named.replaceAll('_', ' ') : `unnamed ${id.slice(0, 6)}`;
}

/** UTF-8 bytes of a name that the server takes. */
const MOST_BYTES = 200;

/** Why the server would not take a name, in a sentence; empty where it would. */
export function nameFault(name: string): string {
  const bytes = new TextEncoder().encode(name).length;
  return bytes <= MOST_BYTES ? '' : `A name has at most ${MOST_BYTES} bytes, and this one ${bytes}: a letter takes one to four. Shorten it.`;
}

/** How the file was read, where that is not as usual: `scale 0.001, up z`. */
function readingText({ import: reading }: MeshMetadata): string {
  return Object.entries(reading).map(([option, value]) => `${option} ${value}`).join(', ');
}

/** A name for each of several meshes, apart from those of the others: two readings of one file, too. */
export function meshLabels(meshes: readonly MeshMetadata[]): string[] {
  const labels = meshes.map((about) => [meshName(about), readingText(about)].filter(Boolean).join(' · '));
  const counts = new Map<string, number>();
  for (const label of labels) counts.set(label, (counts.get(label) ?? 0) + 1);
  return meshes.map((about, index) => {
    const label = labels[index]!;
    return counts.get(label)! > 1 ? `${label} · ${countText(about.vertices)} · ${about.id.slice(0, 4)}` : label;
  });
}
