/** What is asked before a mesh gets another name, or goes. */
import type { MeshMetadata } from 'geodesicd-client';
import { ask } from './dialog.ts';
import { meshName, nameFault } from './mesh_names.ts';

/** `run` is given the name that was typed, which may be none. */
export function askName(about: MeshMetadata, run: (name: string) => void): void {
  ask({
    title: 'Rename this mesh',
    text: 'Everybody who uses this server sees the name.',
    input: { label: 'Name; none brings back the one inside the file', properties: { value: about.name ?? '', name: 'mesh-name' }, fault: nameFault },
    yes: 'Rename',
    run,
  });
}

export function askToDelete(about: MeshMetadata, run: () => void): void {
  ask({
    title: `Delete ${meshName(about)}?`,
    text: 'The server forgets the mesh and its file, for everybody. Links to it lead nowhere then.',
    yes: 'Delete',
    grave: true,
    run,
  });
}
