/**
 * Where files come in: dropped anywhere on the page, alone, several or as a folder, or picked.
 * A .gltf takes the files of its buffers along and no others: what lies beside it may be
 * nobody's business. Other meshes come one by one.
 */
import { buffersOf } from './gltf_files.ts';

/** A mesh file, and what belongs to it, by its path from there. */
export interface Dropped {
  readonly file: File;
  readonly others: readonly { readonly name: string; readonly data: File }[];
}

interface Found {
  readonly path: string;
  readonly file: File;
}

const MESH = /\.(glb|gltf|drc|obj|ply|stl)$/i;
const GLTF = /\.gltf$/i;

/** What is to be uploaded of all that came. */
export async function meshesAmong(found: readonly Found[]): Promise<Dropped[]> {
  const meshes = found.filter(({ path }) => MESH.test(path));
  // One file that is no mesh by its name may be one all the same: the server looks inside.
  if (!meshes.length) return found.slice(0, 1).map(({ file }) => ({ file, others: [] }));
  const byPath = new Map(found.map(({ path, file }) => [path, file]));
  return Promise.all(meshes.map(async ({ path, file }) => {
    const folder = path.slice(0, path.lastIndexOf('/') + 1);
    const named = GLTF.test(path) && found.length > 1 ? await buffersOf(file) : [];
    // Files that were picked one by one have lost their folders: the server, too, then looks for the bare name.
    const names = new Set(named.map((name) => (byPath.has(folder + name) ? name : name.slice(name.lastIndexOf('/') + 1))));
    const own = [...names].map((name) => ({ name, data: byPath.get(folder + name) }));
    return { file, others: own.filter((each): each is { name: string; data: File } => each.data !== undefined) };
  }));
}

/** The files that a glTF needs for its buffers and that did not come with it; none where it cannot be read. */
export async function missingOf({ file, others }: Dropped): Promise<string[]> {
  try {
    const { buffers } = JSON.parse(await file.text()) as { buffers: readonly { uri?: string }[] };
    const names = buffers.map(({ uri }) => uri).filter((uri) => uri && !uri.startsWith('data:')).map((uri) => decodeURIComponent(uri!));
    return [...new Set(names)].filter((name) => !others.some((other) => other.name === name));
  } catch {
    return []; // the server says one of them
  }
}

async function filesIn(entry: FileSystemEntry, folder = ''): Promise<Found[]> {
  const path = folder + entry.name;
  if (entry.isFile) {
    const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
    return [{ path, file }];
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const all: Found[] = [];
  for (;;) {
    // A reader gives a hundred at a time, and none at the end.
    const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) return all;
    for (const each of some) all.push(...(await filesIn(each, `${path}/`)));
  }
}

async function filesOf(data: DataTransfer): Promise<Found[]> {
  // Entries must be asked for before anything is awaited.
  const entries = [...data.items].map((item) => item.webkitGetAsEntry?.() ?? null);
  const files = [...data.files].map((file) => ({ path: file.name, file }));
  if (!entries.some((entry) => entry?.isDirectory)) return files;
  return (await Promise.all(entries.filter((entry) => entry !== null).map((entry) => filesIn(entry)))).flat();
}

/** `take` is given what is to be uploaded; `open` lets files be picked. */
export function fileEntrance(take: (dropped: Dropped[]) => void): { open(): void } {
  const input = document.createElement('input');
  Object.assign(input, { type: 'file', multiple: true, accept: '.glb,.gltf,.drc,.obj,.ply,.stl,.bin,model/gltf-binary,model/gltf+json', hidden: true, tabIndex: -1 });
  input.setAttribute('aria-label', 'Mesh file');
  input.onchange = () => {
    const files = [...(input.files ?? [])].map((file) => ({ path: file.name, file }));
    input.value = ''; // the same file can be picked again
    if (files.length) void meshesAmong(files).then(take);
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
    if (!event.dataTransfer) return;
    void filesOf(event.dataTransfer).then(async (files) => { if (files.length) take(await meshesAmong(files)); });
  });
  return { open: () => input.click() };
}
