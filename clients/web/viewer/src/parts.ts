/** What every part of the panel is given: the two stores, and what the page can do. */
import type { Reading } from 'geodesicd-client';
import type { Across } from './drawing.ts';
import type { Results } from './results.ts';
import type { Axis, State, Store } from './state.ts';

export interface Actions {
  open(): void;
  chooseMesh(id: string): void;
  /** Reads the file of the present mesh in another way. */
  readAgain(reading: Reading): void;
  /** Asks for another name of the present mesh. */
  renameMesh(): void;
  /** Asks whether the present mesh is to be deleted on the server. */
  deleteMesh(): void;
  /** Looks at all of the mesh again. */
  fit(): void;
  /** Puts this axis up. */
  turn(axis: Axis): void;
  compare(): void;
  /** Closes the line that is drawn. */
  closeLoop(): void;
  /** Makes a wall, or a source, of the line that is drawn. */
  use(as: 'wall' | 'curve'): void;
  /** Lays a loop round the one point that is drawn, in a plane. */
  roundHere(across: Across): void;
  /** Moves the sources towards the middles of their cells. */
  relax(): void;
  /** Places points that were typed as the tool says; whether it could. */
  placeTyped(points: string): Promise<boolean>;
  /** Sources out of a text file: a point a line. */
  sourcesFrom(file: File): void;
  keep(): void;
  clear(): void;
  copyLink(): void;
  exported(kind: ExportKind): void;
}

export type ExportKind = 'png' | 'field.glb' | 'path.glb' | 'path.json' | 'path.csv' | 'loop.glb' | 'cells.glb' | 'field.npy' | 'measures.csv';

export interface Parts {
  readonly state: Store<State>;
  readonly results: Store<Results>;
  readonly actions: Actions;
}
