/**
 * Brings meshes onto the page: the server's list, one of them by its id, or a file that
 * is dropped or picked, with the progress of its way up.
 */
import { digestOf, GeodesicError, type MeshMetadata } from 'geodesicd-client';
import type { Access } from './access.ts';
import type { Connection } from './connection.ts';
import { troubleOf } from './messages.ts';
import type { Notices } from './notices.ts';
import { bytesText, countText } from './numbers.ts';
import type { Results } from './results.ts';
import type { Store } from './state.ts';
import { Surface } from './surface.ts';

/** The list shows so many; a mesh beyond them is reached by its link. */
const LISTED = 200;
/** The first mesh that is shown has at most so many faces. */
const MODEST = 200_000;

export class Meshes {
  #loading: AbortController | null = null;

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
   * Puts a mesh into the results; whatever goes wrong is told. Answers whether it is there.
   * `before` sees it first: with it in the results, questions about it are asked.
   */
  async load(id: string, before: (surface: Surface) => void): Promise<boolean> {
    this.#loading?.abort();
    const loading = (this.#loading = new AbortController());
    const { signal } = loading;
    const progress = this.notices.begin('Fetching the mesh', () => loading.abort());
    try {
      const listed = this.results.value.meshes.find((mesh) => mesh.id === id);
      const [about, { positions, triangles }] = await Promise.all([
        listed ?? this.access.client.mesh(id, { signal }),
        this.access.client.geometry(id, { values: 'f64', signal }),
      ]);
      if (signal.aborted) return false;
      const surface = new Surface(about, positions, triangles);
      before(surface);
      this.results.value.surface?.dispose();
      this.results.set({ surface });
      this.#add(about);
      return true;
    } catch (error) {
      if (!signal.aborted && !this.connection.explains(error)) {
        this.notices.trouble(troubleOf(error), this.access.remedy(error));
      }
      return false;
    } finally {
      progress.end();
    }
  }

  /** Sends a file up unless it is there; its id, or null where that failed, which is told. */
  async upload(file: File): Promise<string | null> {
    const uploading = new AbortController();
    const { signal } = uploading;
    const what = `Uploading ${file.name}`;
    const progress = this.notices.begin(what, () => uploading.abort());
    try {
      progress.say(`Reading ${file.name}`);
      // The list knows most: no question that the server would answer by an error.
      const id = await digestOf(file);
      signal.throwIfAborted();
      const known = this.results.value.meshes.find((mesh) => mesh.id === id);
      if (known) return known.id;
      const about = await this.access.client.uploadJob(file, {
        digest: false,
        signal,
        onSent: (sent, total) => progress.say(`${what} · ${bytesText(sent)} of ${bytesText(total)}`, sent / total),
        onProgress: (job) => progress.say(`Checking ${file.name}`, job.progress),
      });
      this.#add(about);
      return about.id;
    } catch (error) {
      if (signal.aborted || this.connection.explains(error)) return null;
      const trouble = troubleOf(error);
      const named = error instanceof GeodesicError ? { ...trouble, detail: `${file.name}: ${trouble.detail}` } : trouble;
      this.notices.trouble(named, this.access.remedy(error));
      return null;
    } finally {
      progress.end();
    }
  }

  #add(about: MeshMetadata): void {
    const { meshes } = this.results.value;
    if (!meshes.some(({ id }) => id === about.id)) this.#setList([...meshes, about]);
  }

  #setList(meshes: readonly MeshMetadata[]): void {
    const order = (mesh: MeshMetadata) => `${Surface.nameOf(mesh)} ${countText(mesh.vertices)} ${mesh.id}`;
    this.results.set({ meshes: [...meshes].sort((a, b) => order(a).localeCompare(order(b))) });
  }
}

/** Lets files be dropped anywhere on the page, and picked by `open`. */
export function fileEntrance(take: (file: File) => void): { open(): void } {
  const input = document.createElement('input');
  Object.assign(input, { type: 'file', accept: '.glb,.gltf,.drc,.obj,.ply,.stl,model/gltf-binary,model/gltf+json', hidden: true, tabIndex: -1 });
  input.setAttribute('aria-label', 'Mesh file');
  input.onchange = () => {
    const [file] = input.files ?? [];
    input.value = ''; // the same file can be picked again
    if (file) take(file);
  };
  document.body.append(input);

  const over = (on: boolean) => document.body.classList.toggle('dropping', on);
  addEventListener('dragover', (event) => {
    if (!event.dataTransfer?.types.includes('Files')) return;
    event.preventDefault();
    over(true);
  });
  addEventListener('dragleave', (event) => { if (!event.relatedTarget) over(false); });
  addEventListener('drop', (event) => {
    event.preventDefault();
    over(false);
    const [file] = event.dataTransfer?.files ?? [];
    if (file) take(file);
  });
  return { open: () => input.click() };
}
