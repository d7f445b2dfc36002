/** The panel's part for taking results along. */
import { element } from './element.ts';
import { part } from './panel.ts';
import type { ExportKind, Parts } from './parts.ts';
import type { Results } from './results.ts';

const KINDS: readonly { kind: ExportKind; label: string; title: string; has: (of: Results) => boolean }[] = [
  { kind: 'png', label: 'View · PNG', title: 'What you see, with its legend', has: ({ surface }) => surface !== null },
  { kind: 'field.glb', label: 'Distance · GLB', title: 'The mesh, coloured by distance whatever is shown', has: ({ field }) => field !== null },
  { kind: 'path.glb', label: 'Path · GLB', title: 'A line strip for any 3D program', has: hasPath },
  { kind: 'path.json', label: 'Path · JSON', title: 'Points with their faces, as the server answered', has: hasPath },
  { kind: 'path.csv', label: 'Path · CSV', title: 'Points with the distance walked', has: hasPath },
  { kind: 'loop.glb', label: 'Loop · GLB', title: 'A closed line for any 3D program', has: ({ drawn }) => drawn?.loop != null },
  { kind: 'cells.glb', label: 'Cells · GLB', title: 'The surface cut into its cells, a coloured mesh each', has: ({ cells }) => cells !== null },
  { kind: 'field.npy', label: 'Field · NPY', title: 'A distance a vertex, for NumPy', has: ({ field }) => field !== null },
];

/** A path of other points than the present ones is shown faded, and not given away. */
function hasPath({ path, stale }: Results): boolean {
  return !stale && (path?.reachable ?? false);
}

export function exportPart({ results, actions }: Parts): HTMLElement {
  const buttons = KINDS.map(({ kind, label, title, has }) => ({
    has,
    button: element('button', { type: 'button', title, onclick: () => actions.exported(kind) }, label),
  }));
  const link = element('button', { type: 'button', title: 'It reproduces the mesh, the points and the view', onclick: actions.copyLink }, 'Share link');
  const root = part('Export', false, element('div', { className: 'grid' }, ...buttons.map(({ button }) => button), link));
  const follow = () => {
    for (const { has, button } of buttons) button.disabled = !has(results.value);
  };
  results.listen(follow);
  follow();
  return root;
}
