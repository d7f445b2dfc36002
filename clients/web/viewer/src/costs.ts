/** Ways that cost least, by slopes or by weights of faces: as texts of links, as what is asked, and as what is said of them. */
import type { Method } from 'geodesicd-client';
import { lengthText } from './numbers.ts';
import { weightsOf } from './painted.ts';
import { byCost, type Axis, type Painted, type Walking } from './state.ts';

export type Cost = Walking['by'] | 'weights';

const UP: Readonly<Record<Axis, string>> = { x: '1,0,0', y: '0,1,0', z: '0,0,1' };

export interface Asked {
  readonly method: string;
  readonly pointsPerEdge: number | null;
  readonly walking: Walking | null;
  readonly painted: Painted;
}

/** The method that computes: costs have only steiner. */
export function methodUsed(asked: Omit<Asked, 'pointsPerEdge'>): string {
  return byCost(asked) ? 'steiner' : asked.method;
}

/** The parameters of the method and of what ways cost. */
export function methodAndCosts(asked: Asked) {
  const { pointsPerEdge, walking, painted } = asked;
  const slope = walking ? { slope: walking.by, up: UP[walking.up] } : {};
  return { ...methodOf({ method: methodUsed(asked), pointsPerEdge }), ...slope, ...weightsOf(painted) };
}

/** The parameters of the method; only steiner has one. */
export function methodOf({ method, pointsPerEdge }: Pick<Asked, 'method' | 'pointsPerEdge'>) {
  const steiner = method === 'steiner' && pointsPerEdge !== null;
  return { method: method as Method, ...(steiner ? { points_per_edge: pointsPerEdge } : {}) };
}

/** What ways are to have least; null: length alone. */
export function costKind(asked: Pick<Asked, 'walking' | 'painted'>): Cost | null {
  return byCost(asked) ? (asked.walking?.by ?? 'weights') : null;
}

export const ONLY_STEINER = 'Least costs are computed by Steiner';

/** By the unit of an answer. */
export function costOfUnit(unit: string | undefined): Cost {
  return unit === 'seconds' ? 'tobler' : unit === 'joules_per_kilogram' ? 'energy' : 'weights';
}

/** Such as `tobler,y`; empty where ways are to be short. */
export function walkingText(walking: Walking | null): string {
  return walking ? `${walking.by},${walking.up}` : '';
}

/** By itself an axis means the quickest way. */
export function walkingIn(text: string | null): Walking | null {
  const [, by = 'tobler', up] = /^(?:(tobler|energy),)?([xyz])$/.exec(text ?? '') ?? [];
  return up ? { by: by as Walking['by'], up: up as Axis } : null;
}

/** Titles, and a cost in the unit that it is read in. */
export const SAID: Readonly<Record<Cost, { title: string; field: string; text(cost: number): string }>> = {
  tobler: {
    title: 'Quickest way',
    field: 'Seconds on foot',
    text: (cost) => (cost < 90 ? `${lengthText(cost)} s on foot` : `${lengthText(cost / 60)} min on foot`),
  },
  energy: {
    title: 'Way of least energy',
    field: 'Joules per kilogram',
    text: (cost) => (cost < 1000 ? `${lengthText(cost)} J/kg on foot` : `${lengthText(cost / 1000)} kJ/kg on foot`),
  },
  weights: {
    title: 'Path of least cost',
    field: 'Length times weight',
    text: (cost) => `cost ${lengthText(cost)}`,
  },
};
