/**
 * Regions of the nearest source, hundreds of them: a colour for each, apart from those of
 * the regions that it touches, and one of eight slots, in which two that touch never meet,
 * so that the shader can tell the regions of a face by their slots.
 */
import { UNREACHED } from 'geodesicd-client';
import { LIGHTNESSES, regionColour } from './colour_maps.ts';
import { apartBy, oklabOf } from './oklab.ts';
import { REGIONS } from './state.ts';

export interface RegionLook {
  /** For each source, from 0 to 7. */
  readonly slots: Uint8Array;
  /** For each source, such as `#e8835a`. */
  readonly colours: readonly string[];
}

/** The colour of a source's region, whether or not it is known yet what it touches. */
export function hueOf(look: RegionLook | null, index: number): string {
  return look?.colours[index] ?? regionColour(index);
}

/** Regions that touch are at least so far apart in OKLab. */
const APART = 0.09;

/** So many colours are looked at for a region. */
const TRIES = 64;

/**
 * `labels`: the nearest source of each vertex; `triangles`: three vertices a face; `count`:
 * how many sources there are.
 */
export function lookOf(labels: Uint32Array, triangles: Uint32Array, count: number): RegionLook {
  const colours = Array.from({ length: count }, (_, index) => regionColour(index));
  const slots = Uint8Array.from(colours, (_, index) => index % REGIONS);
  if (count <= REGIONS) return { slots, colours }; // those differ as they are
  // From one try to the next, lightness changes as well as hue.
  const step = count + ((LIGHTNESSES + 1 - (count % LIGHTNESSES)) % LIGHTNESSES);
  const touching = touches(labels, triangles, count);
  const labs = colours.map(oklabOf);
  const done = new Array<boolean>(count).fill(false);
  for (const label of smallestLast(touching)) {
    const neighbours = [...touching[label]!].filter((other) => done[other]);
    done[label] = true;
    const taken = new Set(neighbours.map((other) => slots[other]!));
    // A surface with many handles may need more slots than there are: two regions then blend.
    const free = Array.from({ length: REGIONS }, (_, slot) => slot).find((slot) => !taken.has(slot));
    slots[label] = free ?? label % REGIONS;
    // Most keep their own colour, so that it stays while a source is dragged.
    let widest = -1;
    for (let next = label, tries = 0; tries < TRIES && widest < APART; tries++, next += step) {
      const colour = regionColour(next);
      const lab = oklabOf(colour);
      const apart = Math.min(...neighbours.map((other) => apartBy(lab, labs[other]!)));
      if (apart <= widest) continue;
      widest = apart;
      colours[label] = colour;
      labs[label] = lab;
    }
  }
  return { slots, colours };
}

/** Which regions share a face. */
function touches(labels: Uint32Array, triangles: Uint32Array, count: number): Set<number>[] {
  const touching = Array.from({ length: count }, () => new Set<number>());
  const meet = (a: number, b: number) => {
    if (a === b || a >= count || b >= count || a === UNREACHED || b === UNREACHED) return;
    touching[a]!.add(b);
    touching[b]!.add(a);
  };
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [labels[triangles[i]!]!, labels[triangles[i + 1]!]!, labels[triangles[i + 2]!]!];
    if (a === b && b === c) continue;
    meet(a, b);
    meet(b, c);
    meet(c, a);
  }
  return touching;
}

/**
 * The smallest-last order (Matula and Beck 1983): the region that touches the fewest others
 * comes last, the next one is chosen among the rest in the same way, and so on. On a sphere or
 * a plane each region then comes after at most five that it touches, so six slots are enough.
 */
function smallestLast(touching: readonly Set<number>[]): number[] {
  const left = touching.map((set) => set.size);
  const waiting = new Set(left.keys());
  const order: number[] = [];
  while (waiting.size) {
    let fewest = -1;
    for (const one of waiting) if (fewest < 0 || left[one]! < left[fewest]!) fewest = one;
    waiting.delete(fewest);
    order.push(fewest);
    for (const other of touching[fewest]!) left[other]!--;
  }
  return order.reverse();
}
