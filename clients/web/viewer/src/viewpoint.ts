/** Where the mesh is looked at from, and which of its axes is up: all of it, or as the state's camera says. */
import { Vector3 } from 'three';
import type { MeshMetadata } from 'geodesicd-client';
import type { Results } from './results.ts';
import type { Stage } from './stage.ts';
import type { Axis, State, Store } from './state.ts';
import { rememberUp, upOf } from './upright.ts';

const AXES = ['y', 'z', 'x'] as const;

export class Viewpoint {
  /** Whether the axis that is up was chosen for this mesh. */
  #turned = false;

  constructor(
    private readonly stage: Stage,
    private readonly state: Store<State>,
    private readonly results: Store<Results>,
  ) {}

  /** All of the mesh. */
  fit(): void {
    const { surface } = this.results.value;
    if (!surface) return;
    // Points stay as they are seen; only a fresh mesh that is flat is looked straight at.
    this.stage.fit(surface.geometry.boundingBox!.getSize(new Vector3()), this.state.value.up ?? upOf(surface.about), this.#turned);
    this.state.set({ camera: null });
  }

  /** Another axis up, as its reader chooses. */
  turn(axis: Axis): void {
    const about = this.results.value.surface?.about;
    if (!about) return;
    rememberUp(about, axis);
    this.#turned = true;
    this.state.set({ up: axis });
    this.fit();
  }

  nextUp(): void {
    const now = AXES.findIndex((axis) => this.stage.camera.up[axis] === 1);
    this.turn(AXES[(now + 1) % AXES.length]!);
  }

  /** As a link says, or what was seen of this mesh before: without a camera at all of the mesh. */
  look({ up, camera }: Pick<State, 'up' | 'camera'>): void {
    this.#turned = up !== null;
    this.fit(); // for the axis that is up, too
    if (!camera) return;
    this.stage.view = camera;
    this.state.set({ camera });
  }

  /** At a mesh of which only the sides of its box are known yet. */
  foresee(about: MeshMetadata, sides: Vector3): void {
    const { up, camera } = this.state.value;
    this.stage.fit(sides, up ?? upOf(about), up !== null);
    if (camera) this.stage.view = camera;
  }
}
