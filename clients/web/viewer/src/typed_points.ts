/**
 * Points that are typed or come out of a file: where on the surface they are, which only the
 * server knows of places in space, and what they become. Nothing is left out without a word.
 */
import type { GeodesicClient } from 'geodesicd-client';
import type { Access } from './access.ts';
import type { Connection } from './connection.ts';
import { withPoints } from './drawing.ts';
import { spotOf } from './spot_text.ts';
import { fullText, LOOP_IS_FULL, troubleOf, VIA_IS_FULL, type Trouble } from './messages.ts';
import type { Notices } from './notices.ts';
import { countText, lengthText } from './numbers.ts';
import { regionsOf } from './painted.ts';
import { checked, entriesIn, entriesInFile, type Entry, type Typed } from './point_text.ts';
import { surfaceOf, type Results } from './results.ts';
import { tooLarge } from './sources_file.ts';
import { MOST_SOURCES, MOST_VIA, type Painted, type Spot, type State, type Store, type Tool, type Xyz } from './state.ts';
import type { Surface } from './surface.ts';

/** Points that are farther from the surface than this part of the mesh's size are remarked on. */
const FAR = 0.05;
/** So many lines of a file are told; of the others their number. */
const TOLD = 3;

/** Places in space that are far from the surface: how many, of how many, and how far the farthest is (mesh units). */
interface FarPlaces {
  readonly count: number;
  readonly of: number;
  readonly farthest: number;
}

/** Where the points are on the surface, null where they are nowhere, and which places are far from it. Rejects as the client does. */
async function spotsOf(
  points: readonly Typed[],
  surface: Surface,
  client: GeodesicClient,
  painted: Painted,
): Promise<{ spots: (Spot | null)[]; far: FarPlaces | null }> {
  const places = points.filter((point): point is Xyz => Array.isArray(point));
  const found = places.length ? (await client.nearest(surface.id, { point: places.map((xyz) => ({ xyz })), ...regionsOf(painted) })).points : [];
  let next = 0;
  const spots = points.map((point) => {
    if (typeof point === 'number') return surface.spotAt(point);
    if ('face' in point) return point;
    const { face, bary } = found[next++]!;
    return face == null || !bary ? null : spotOf(face, bary[0]!, bary[1]!);
  });
  const { min, max } = surface.about.bbox;
  const limit = FAR * Math.hypot(...max.map((upper, axis) => upper - min[axis]!));
  const away = found.map(({ snap_distance }) => snap_distance).filter((distance) => distance > limit);
  return { spots, far: away.length ? { count: away.length, of: places.length, farthest: Math.max(...away) } : null };
}

function farText({ count, of, farthest }: FarPlaces): Trouble {
  return {
    title: 'Far from the surface',
    advice: 'Points were moved to the nearest place on the mesh. Check their unit and their axes.',
    detail: `${of > 1 ? `${countText(count)} of ${countText(of)} points, up to ` : ''}${lengthText(farthest)} away`,
    about: 'points',
  };
}

export interface TypedOptions {
  readonly state: Store<State>;
  readonly results: Store<Results>;
  readonly notices: Notices;
  readonly access: Access;
  readonly connection: Connection;
  /** Does with one place what the tool says. */
  readonly place: (tool: Tool, spot: Spot) => void;
}

export class TypedPoints {
  constructor(private readonly options: TypedOptions) {}

  /** Places what was typed as the tool says, all or nothing; whether it could. */
  async place(text: string): Promise<boolean> {
    const { state, results, notices, place } = this.options;
    const surface = surfaceOf(state.value, results.value);
    if (!surface) return false;
    const entries = checked(entriesIn(text), surface);
    const wrong = entries.find(({ fault }) => fault);
    if (wrong) notices.trouble({ ...wrong.fault!, detail: wrong.text.slice(0, 200), about: 'points' });
    if (wrong || !entries.length) return false;
    const { tool } = state.value; // what was typed is for the tool of that moment
    if (entries.length > 1 && (tool === 'target' || tool === 'arrow')) {
      notices.trouble({
        title: tool === 'target' ? 'A path has one target' : 'An arrow has one start',
        advice: 'Type one point, or choose the tool Source, Add or Via for several.',
        detail: `These are ${countText(entries.length)}: ${text.slice(0, 200)}`,
        about: 'points',
      });
      return false;
    }
    const found = await this.#locate(entries, surface);
    if (!found) return false;
    const lost = found.spots.indexOf(null);
    if (lost >= 0) {
      notices.trouble({ title: 'No face has this vertex', advice: 'Points are placed on faces: choose another vertex.', detail: entries[lost]!.text, about: 'points' });
      return false;
    }
    const spots = found.spots as Spot[];
    const { sources, via, loop } = state.value; // of now: others may have been placed meanwhile
    if (tool === 'source' && spots.length > 1) this.#sources(spots, spots.length);
    else if (tool === 'add') this.#sources([...sources, ...spots], sources.length + spots.length);
    else if (tool === 'via') {
      state.set({ via: [...via, ...spots].slice(0, MOST_VIA) });
      if (via.length + spots.length > MOST_VIA) notices.remark(VIA_IS_FULL); // now: points that move take such words away
    } else if (tool === 'loop') {
      const { line, full } = withPoints(loop, spots);
      state.set({ loop: line });
      if (full) notices.remark(LOOP_IS_FULL);
    } else for (const spot of spots) place(tool, spot);
    if (found.far) notices.remark(farText(found.far));
    return true;
  }

  /** The points of a text file as sources. Lines that cannot be read are told, the others taken. */
  async fromFile(file: File): Promise<void> {
    const { state, results, notices } = this.options;
    const surface = surfaceOf(state.value, results.value);
    if (!surface) return;
    const large = tooLarge(file);
    if (large) return notices.trouble({ ...large, about: 'points' });
    const entries = checked(entriesInFile(await file.text()), surface);
    const right = entries.filter(({ fault }) => !fault);
    const asked = right.slice(0, MOST_SOURCES);
    const found = await this.#locate(asked, surface);
    if (!found) return;
    const lost: Entry[] = asked.filter((_, index) => !found.spots[index])
      .map((entry) => ({ ...entry, fault: { title: 'No face has this vertex', advice: 'Points are placed on faces.' } }));
    const spots = found.spots.filter((spot) => spot !== null);
    if (spots.length) this.#sources(spots, right.length - lost.length);
    if (found.far) notices.remark(farText(found.far));
    const wrong = [...entries.filter(({ fault }) => fault), ...lost].sort((a, b) => a.line - b.line);
    if (!spots.length || wrong.length) notices.trouble(fileTrouble(file.name, wrong, spots.length));
  }

  /** Where points are on the surface; null where it could not be asked, or there is another mesh. */
  async #locate(entries: readonly Entry[], surface: Surface): Promise<Awaited<ReturnType<typeof spotsOf>> | null> {
    const { state, results, notices, access, connection } = this.options;
    try {
      const found = await spotsOf(entries.map(({ point }) => point!), surface, access.client, state.value.painted);
      return surfaceOf(state.value, results.value) === surface ? found : null;
    } catch (error) {
      if (!connection.explains(error)) notices.trouble({ ...troubleOf(error), about: 'points' }, access.remedy(error));
      return null;
    }
  }

  /** `count` is how many there were. */
  #sources(sources: readonly Spot[], count: number): void {
    const { state, notices } = this.options;
    state.set({ sources: sources.slice(0, MOST_SOURCES), tool: state.value.target ? state.value.tool : 'target' });
    if (count > MOST_SOURCES) notices.remark(fullText(count));
  }
}

function fileTrouble(name: string, wrong: readonly Entry[], taken: number): Trouble {
  const lines = wrong.slice(0, TOLD).map(({ line, text }) => `line ${countText(line)}: ${text.slice(0, 80)}`);
  const more = wrong.length > TOLD ? [`and ${countText(wrong.length - TOLD)} more`] : [];
  const [first] = wrong;
  return {
    title: taken ? `${countText(wrong.length)} of ${countText(wrong.length + taken)} points were left out` : 'No sources in this file',
    advice: first ? `${first.fault!.title}. ${first.fault!.advice}` : 'It should have a point on each line: a vertex number, or x y z.',
    detail: [name, ...lines, ...more].join(' · '),
    about: 'points',
  };
}
