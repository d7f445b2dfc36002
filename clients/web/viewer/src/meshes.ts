/**
 * Brings meshes onto the page: the server's list, one of them by its id, or a file that
 * is dropped or picked, with the progress of its way up.
 */
import { digestOf, GeodesicError, type ArrivingGeometry, type MeshMetadata, type Reading } from 'geodesicd-client';
import type { Access } from './access.ts';
import type { Connection } from './connection.ts';
import { missingOf, type Dropped } from './entrance.ts';
import { meshLabels, meshName } from './mesh_names.ts';
import { troubleOf } from './messages.ts';
import { SLOW, type Notices } from './notices.ts';
import { bytesText, countText } from './numbers.ts';
import type { Results } from './results.ts';
import type { Store } from './state.ts';
import { Surface } from './surface.ts';

/** The list shows so many; a mesh beyond them is reached by its link. */
const LISTED = 200;
/** The first mesh that is shown has at most so many faces. */
const MODEST = 200_000;

/**
 * How a load ended: the mesh is there; it does not come, which was told or is its reader's
 * wish; it comes when the server is back; or nobody waits for it any more.
 */
export type Loaded = 'there' | 'failed' | 'lost' | 'left';

export class Meshes {
  #loading: AbortController | null = null;
  #uploading: AbortController | null = null;

  constructor(
    private readonly access: Access,
    private readonly results: Store<Results>,
    private readonly notices: Notices,
    private readonly connection: Connection,
  ) {}

  /** Fetches the list. Rejects as the client does. */
  async list(): Promise<void> {
    const found: MeshMetadata[] = [];
    for await (const mesh of this.access.client.meshes({ limit: LISTED })) {
      found.push(mesh);
      if (found.length === LISTED) break;
    }
    // One that came by a link may lie beyond the list's end.
    const { surface } = this.results.value;
    if (surface && !found.some(({ id }) => id === surface.id)) found.push(surface.about);
    this.#setList(found);
  }

  /** A first mesh to look at: closed if there is one, and as rich as every device draws with ease. */
  get first(): string | null {
    const modest = this.results.value.meshes.filter(({ faces, format }) => faces <= MODEST && format !== 'drc');
    const rich = modest.sort((a, b) => a.boundary_loops - b.boundary_loops || b.faces - a.faces);
    return rich[0]?.id ?? this.results.value.meshes[0]?.id ?? null;
  }

  /**
   * The id of the mesh of this name; null where there is none, or several, which is told. Looked for among all that
   * the server has, where the list does not show it.
   */
  async called(name: string): Promise<string | null> {
    const { meshes } = this.results.value;
    const labels = meshLabels(meshes);
    let found: readonly MeshMetadata[] | null = meshes.filter((mesh, index) => meshName(mesh) === name || labels[index] === name);
    if (!found.length && meshes.length >= LISTED) found = await this.#calledAnywhere(name);
    if (!found) return null;
    if (found.length === 1) return found[0]!.id;
    this.notices.trouble({
      title: found.length ? `${countText(found.length)} meshes have this name` : 'No mesh has this name',
      advice: 'Choose one from the list, or open a file.',
      detail: name.slice(0, 200),
    });
    return null;
  }

  /** Null where the search was stopped or failed, which is told. */
  async #calledAnywhere(name: string): Promise<readonly MeshMetadata[] | null> {
    const looking = new AbortController();
    const progress = this.notices.begin('Looking for the mesh', () => looking.abort());
    const found: MeshMetadata[] = [];
    try {
      for await (const mesh of this.access.client.meshes({ limit: 1000, signal: looking.signal })) {
        if (meshName(mesh) === name) found.push(mesh);
        if (found.length > 1) break;
      }
    } catch (error) {
      if (looking.signal.aborted || this.connection.explains(error)) return null;
      this.notices.trouble(troubleOf(error), this.access.remedy(error));
      return null;
    } finally {
      progress.end();
    }
    for (const mesh of found) this.#put(mesh);
    return found;
  }

  /**
   * Puts a mesh into the results; whatever goes wrong is told.
   * `before` sees it first: with it in the results, questions about it are asked. `arriving`
   * sees what has come of it meanwhile.
   */
  async load(
    id: string,
    before: (surface: Surface) => void,
    arriving: (about: MeshMetadata, part: ArrivingGeometry) => void,
  ): Promise<Loaded> {
    this.#loading?.abort();
    const loading = (this.#loading = new AbortController());
    const { signal } = loading;
    const progress = this.notices.begin('Fetching the mesh', () => loading.abort());
    try {
      const listed = this.results.value.meshes.find((mesh) => mesh.id === id);
      // The one or the other may come first.
      let known = listed;
      let part: ArrivingGeometry | null = null;
      const tell = () => { if (known && part) arriving(known, part); };
      const [about, { positions, triangles }] = await Promise.all([
        listed ?? this.access.client.mesh(id, { signal }).then((mesh) => { known = mesh; tell(); return mesh; }),
        this.access.client.geometry(id, {
          values: 'f64',
          signal,
          onArrival: (more) => {
            part = more;
            progress.say('Fetching the mesh', more.faces / (more.triangles.length / 3));
            tell();
          },
        }),
      ]);
      signal.throwIfAborted();
      const surface = new Surface(about, positions, triangles);
      before(surface);
      this.results.value.surface?.dispose();
      this.results.set({ surface });
      this.#put(about);
      return 'there';
    } catch (error) {
      if (this.#loading !== loading) return 'left';
      if (signal.aborted) return 'failed';
      if (this.connection.explains(error)) return 'lost';
      this.notices.trouble(troubleOf(error), this.access.remedy(error));
      if (isUnknown(error)) this.#drop(id);
      return 'failed';
    } finally {
      progress.end();
    }
  }

  /**
   * Sends a file up unless it is there, or a glTF with the files of its buffers; its id, or
   * null where that failed, which `tell` is told. Without `name` it is called as the file.
   */
  async upload(
    { file, others }: Dropped,
    reading: Reading = {},
    name?: string,
    tell: Notices['trouble'] = (...told) => this.notices.trouble(...told),
  ): Promise<string | null> {
    const uploading = (this.#uploading = new AbortController());
    const { signal } = uploading;
    const what = `Uploading ${file.name}`;
    const progress = this.notices.begin(what, () => uploading.abort());
    try {
      progress.say(`Reading ${file.name}`);
      const asIs = !others.length && Object.values(reading).every((value) => value === undefined);
      // The list knows most: no question that the server would answer by an error.
      const id = asIs ? await digestOf(file) : undefined;
      signal.throwIfAborted();
      const known = this.results.value.meshes.find((mesh) => mesh.id === id);
      // Who gives a name, be it none, has the mesh already and wants no other.
      if (known && (known.name || name !== undefined)) return known.id;
      if (known) {
        this.#put(await this.access.client.upload(file, { signal })); // it is called by the file's name now
        return known.id;
      }
      const named = [{ name: file.name, data: file }, ...others];
      const about = await this.access.client.uploadJob(others.length ? named : file, {
        digest: false,
        name,
        reading,
        signal,
        onSent: (sent, total) => progress.say(`${what} · ${bytesText(sent)} of ${bytesText(total)}`, sent / total),
        onProgress: (job) => progress.say(`Checking ${file.name}`, job.progress),
      });
      this.#put(about);
      return about.id;
    } catch (error) {
      if (signal.aborted) return null;
      if (this.connection.explains(error)) {
        // The page goes on by itself when the server is back; a file is gone for it then.
        tell({ title: 'An upload did not get through', advice: 'Open the file again when the server answers.', detail: `${file.name} was not uploaded` });
        return null;
      }
      const trouble = troubleOf(error);
      const missing = error instanceof GeodesicError && error.code === 'external_uri' ? await missingOf({ file, others }) : [];
      const detail = missing.length ? `needs ${missing.slice(0, 5).join(', ')}${missing.length > 5 ? `, and ${missing.length - 5} more` : ''}` : trouble.detail;
      const named = error instanceof GeodesicError ? { ...trouble, detail: `${file.name}: ${detail}` } : trouble;
      tell(named, this.access.remedy(error));
      return null;
    } finally {
      progress.end();
    }
  }

  /** No mesh but the present one is wanted any more: what is on its way must not take its place. */
  stay(): void {
    const loading = this.#loading;
    this.#loading = null;
    loading?.abort();
  }

  /** Ends what is under way. */
  abandon(): void {
    this.stay();
    this.#uploading?.abort();
  }

  /** The mesh's own file, read in another way. Its id, or null where that failed, which is told. */
  async readAgain(id: string, reading: Reading): Promise<string | null> {
    try {
      const about = this.results.value.surface?.about;
      const source = await this.access.client.source(id);
      const called = about ? meshName(about) : id;
      // A mesh without a name stays without one.
      return await this.upload({ file: new File([source], called), others: [] }, reading, about?.name ?? '');
    } catch (error) {
      if (!this.connection.explains(error)) this.notices.trouble(troubleOf(error), this.access.remedy(error));
      return null;
    }
  }

  /** Gives a mesh another name, or none; what goes wrong is told. */
  async rename(id: string, name: string): Promise<void> {
    await this.#attempt(async () => {
      const about = await this.access.client.renameMesh(id, name);
      const { surface } = this.results.value;
      if (surface?.id === id) surface.about = about;
      this.#put(about);
    });
  }

  /** Deletes a mesh on the server; whether it is gone. What goes wrong is told. */
  async delete(id: string): Promise<boolean> {
    return this.#attempt(async () => {
      await this.access.client.deleteMesh(id).catch((error: unknown) => {
        if (!isUnknown(error)) throw error; // somebody else was faster
      });
      this.#drop(id);
    });
  }

  /** Out of the list, as the server does not have it any more. */
  #drop(id: string): void {
    this.results.set({ meshes: this.results.value.meshes.filter((mesh) => mesh.id !== id) });
  }

  async #attempt(act: () => Promise<void>): Promise<boolean> {
    const progress = this.notices.begin('Waiting for the server', undefined, SLOW);
    try {
      await act();
      return true;
    } catch (error) {
      if (!this.connection.explains(error)) this.notices.trouble(troubleOf(error), this.access.remedy(error));
      return false;
    } finally {
      progress.end();
    }
  }

  /** Into the list, in place of what was known of the same mesh. */
  #put(about: MeshMetadata): void {
    const { meshes } = this.results.value;
    if (!meshes.includes(about)) this.#setList([...meshes.filter(({ id }) => id !== about.id), about]);
  }

  #setList(meshes: readonly MeshMetadata[]): void {
    const labels = meshLabels(meshes);
    const order = meshes.map((mesh, index) => ({ mesh, label: labels[index]! }));
    order.sort((a, b) => a.label.localeCompare(b.label) || a.mesh.id.localeCompare(b.mesh.id));
    this.results.set({ meshes: order.map(({ mesh }) => mesh) });
  }
}

function isUnknown(error: unknown): boolean {
  return error instanceof GeodesicError && error.code === 'mesh_unknown';
}
