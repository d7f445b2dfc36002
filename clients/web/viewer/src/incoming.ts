/** Meshes that come by files: all go up, and the first of them is shown, unless points would be lost by that. */
import type { Reading } from 'geodesicd-client';
import { hasNewPoints } from './arrivals.ts';
import type { Dropped } from './entrance.ts';
import { Failures } from './failures.ts';
import { meshName } from './mesh_names.ts';
import type { Meshes } from './meshes.ts';
import type { Notices } from './notices.ts';
import type { Results } from './results.ts';
import type { State, Store } from './state.ts';

export class Incoming {
  /** `choose` shows a mesh. */
  constructor(
    private readonly state: Store<State>,
    private readonly results: Store<Results>,
    private readonly meshes: Meshes,
    private readonly notices: Notices,
    private readonly choose: (id: string) => Promise<void>,
  ) {}

  /** Files that were opened; `reading` is null where an option cannot be read. */
  async take(dropped: readonly Dropped[], reading: Reading | null): Promise<void> {
    this.notices.clearTroubles();
    if (!reading) {
      this.notices.trouble({ title: 'An import option cannot be read', advice: 'Mend or empty the marked field, then open the file again.', detail: '' });
      return;
    }
    const before = this.state.value;
    const failures = new Failures(this.notices);
    let shown = false;
    for (const each of dropped) {
      const id = await this.meshes.upload(each, reading, undefined, failures.add);
      if (!id || shown) continue;
      shown = true;
      void this.#show(id, before); // the others do not wait for it
      failures.tell(); // another mesh takes away what was said
    }
  }

  /** The file of the present mesh, read in another way. */
  async readAgain(reading: Reading): Promise<void> {
    const { surface } = this.results.value;
    if (!surface) return;
    this.notices.clearTroubles();
    const before = this.state.value;
    const id = await this.meshes.readAgain(surface.id, reading);
    if (id) await this.#show(id, before);
  }

  /** A mesh that has come, unless it would take away points that were placed while it came. */
  async #show(id: string, before: State): Promise<void> {
    if (id === this.state.value.mesh || !hasNewPoints(this.state.value, before)) return this.choose(id);
    const about = this.results.value.meshes.find((mesh) => mesh.id === id);
    this.notices.remark(
      { title: `${about ? meshName(about) : 'The mesh'} is here`, advice: 'It is in the list of meshes: your points stay on the one that you see.', detail: '' },
      { label: 'Show it', run: () => void this.choose(id) },
    );
  }
}
