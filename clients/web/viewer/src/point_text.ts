/**
 * The grammar of points as text, one for what is typed and for files: a vertex, a place on
 * a face, a place in space. What cannot be read is told with the reason.
 */
import { spotOf } from './spot_text.ts';
import { countText } from './numbers.ts';
import type { Spot, Xyz } from './state.ts';
import type { Surface } from './surface.ts';

/** A vertex by its number, a place in mesh units, or a place on a face. */
export type Typed = number | Xyz | Spot;

/** Why a text is no point of the mesh. */
export interface Fault {
  readonly title: string;
  readonly advice: string;
}

/** What stands somewhere for a point: the point, or what is wrong with it. */
export interface Entry {
  readonly text: string;
  /** Of the file, from 1. */
  readonly line: number;
  readonly point: Typed | null;
  readonly fault: Fault | null;
}

const NO_POINT: Fault = {
  title: 'This is no point',
  advice: 'A vertex is 12 or v:12, a place p:x,y,z or x y z, a point in a face f:FACE,b1,b2. Several are separated by ;.',
};
const WHOLE: Fault = { title: 'A vertex has a whole number', advice: 'Vertices are counted from 0. A place is three numbers: p:x,y,z or x y z.' };
const WHOLE_FACE: Fault = { title: 'A face has a whole number', advice: 'A point in a face is f:FACE,b1,b2; faces are counted from 0.' };
const BARY: Fault = {
  title: 'These are no barycentric coordinates',
  advice: 'The weights b1 and b2 of f:FACE,b1,b2 are at least 0, and their sum is at most 1: the third is the rest.',
};

/** `12`, `v:12`, `f:40,0.2,0.3`, `p:1,2,3`, `1 2 3` or `1, 2, 3`. */
function pointIn(text: string): Typed | Fault {
  const [, kind = '', rest = ''] = /^(?:([vfp]):)?(.*)$/i.exec(text)!;
  const words = rest.trim().split(/\s*,\s*|\s+/);
  const numbers = words.map((word) => (word ? Number(word) : NaN));
  const [first, second, third] = numbers as [number, number, number];
  if (!numbers.every(Number.isFinite)) return NO_POINT;
  const whole = Number.isInteger(first) && first >= 0;
  switch (kind.toLowerCase()) {
    case 'v':
      return numbers.length !== 1 ? NO_POINT : whole ? first : WHOLE;
    case 'f':
      if (numbers.length !== 3) return NO_POINT;
      if (!whole) return WHOLE_FACE;
      return second < 0 || third < 0 || second + third > 1 + 1e-9 ? BARY : spotOf(first, second, third);
    case 'p':
      return numbers.length === 3 ? [first, second, third] : NO_POINT;
  }
  if (numbers.length === 3) return [first, second, third];
  if (numbers.length === 1) return whole ? first : WHOLE;
  return { title: `These are ${numbers.length} numbers`, advice: 'One is a vertex, three are a place. Several points are separated by ;.' };
}

function entryOf(text: string, line: number): Entry {
  const read = pointIn(text);
  return typeof read === 'object' && 'title' in read ? { text, line, point: null, fault: read } : { text, line, point: read, fault: null };
}

/**
 * The points of a line, or of a file: one a line, or several with `;` between them, or just a
 * blank where the next says its kind. What follows # is a remark.
 */
export function entriesIn(text: string): Entry[] {
  const entries: Entry[] = [];
  text.split(/\r?\n|\r/).forEach((line, index) => {
    for (const piece of line.replace(/#.*/, '').split(/;|\s+(?=[vfp]:)/i)) {
      if (piece.trim()) entries.push(entryOf(piece.trim(), index + 1));
    }
  });
  return entries;
}

/** The same for a file, whose first line may be a heading: words without a digit. */
export function entriesInFile(text: string): Entry[] {
  const entries = entriesIn(text);
  const heading = entries[0] && !/\d/.test(entries[0].text) && entries.some(({ point }) => point !== null);
  return heading ? entries.filter(({ line }) => line !== entries[0]!.line) : entries;
}

/** With the faults of points that the mesh does not have. */
export function checked(entries: readonly Entry[], surface: Surface): Entry[] {
  return entries.map((entry) => {
    const fault = entry.fault ?? faultOn(entry.point!, surface);
    return fault ? { ...entry, point: null, fault } : entry;
  });
}

function faultOn(point: Typed, { about }: Surface): Fault | null {
  const beyond = (what: string, plural: string, count: number): Fault => ({
    title: `No such ${what}`,
    advice: `This mesh has ${countText(count)} ${plural}, numbered from 0 to ${countText(count - 1)}.`,
  });
  if (typeof point === 'number') return point < about.vertices ? null : beyond('vertex', 'vertices', about.vertices);
  return 'face' in point && point.face >= about.faces ? beyond('face', 'faces', about.faces) : null;
}
