/** What every part of the panel is given: the two stores, and what the page can do. */
import type { Results } from './results.ts';
import type { State, Store } from './state.ts';

export interface Actions {
  open(): void;
  chooseMesh(id: string): void;
  compare(): void;
  keep(): void;
  clear(): void;
  copyLink(): void;
  exported(kind: ExportKind): void;
}

export type ExportKind = 'png' | 'path.glb' | 'path.json' | 'path.csv' | 'field.npy' | 'measures.csv';

export interface Parts {
  readonly state: Store<State>;
  readonly results: Store<Results>;
  readonly actions: Actions;
}
