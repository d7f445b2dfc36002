/** The panel's part for the mesh: which one, a file of one's own, and what is known of it. */
import type { MeshMetadata } from 'geodesicd-client';
import { element, icon } from './element.ts';
import { meshLabels } from './mesh_names.ts';
import { countText, lengthText } from './numbers.ts';
import type { Parts } from './parts.ts';
import { unitOf } from './units.ts';

const UPLOAD = 'M10 13V4M6 8l4-4 4 4M4 13v3h12v-3';
const PENCIL = 'M4 16l.8-3.4L13 4.4a1.4 1.4 0 0 1 2 0l.6.6a1.4 1.4 0 0 1 0 2L7.4 15.2zM11.5 6l2.5 2.5';
const BIN = 'M4 6h12M8 6V4h4v2M6 6l.7 10h6.6L14 6M8.7 9v4.5M11.3 9v4.5';

export function meshPart({ state, results, actions }: Parts, options: HTMLElement): HTMLElement {
  const select = element('select', { id: 'mesh', onchange: () => actions.chooseMesh(select.value) });
  const facts = element('p', { className: 'facts' });
  const button = (label: string, drawing: string, onclick: () => void) =>
    element('button', { type: 'button', className: 'round', title: label, onclick, aria: { label } }, icon(drawing));
  const care = element('div', { className: 'care', hidden: true }, button('Rename this mesh', PENCIL, actions.renameMesh), button('Delete this mesh', BIN, actions.deleteMesh));
  const warnings = element('ul', { className: 'warnings', hidden: true });
  const root = element(
    'section',
    { className: 'mesh-part' },
    element('label', { className: 'out-of-sight', htmlFor: 'mesh' }, 'Mesh'),
    element(
      'div',
      { className: 'row' },
      select,
      element('button', { type: 'button', className: 'primary', onclick: actions.open, title: 'Or drop files or a folder anywhere' }, icon(UPLOAD), 'Open'),
    ),
    element('div', { className: 'row about' }, facts, care),
    warnings,
    options,
  );

  const list = () => {
    const { meshes } = results.value;
    const labels = meshLabels(meshes);
    const options = meshes.map((about, index) => element('option', { value: about.id }, labels[index]!));
    if (!meshes.length) options.push(element('option', { value: '' }, 'No mesh yet: open a file'));
    select.replaceChildren(...options);
    select.value = state.value.mesh ?? '';
  };
  const tell = (about: MeshMetadata | undefined) => {
    facts.replaceChildren();
    warnings.hidden = !about?.warnings.length;
    care.hidden = !about;
    if (!about) return;
    const { vertices, faces, components, boundary_loops: loops } = about;
    const size = [0, 1, 2].map((axis) => lengthText(about.bbox.max[axis]! - about.bbox.min[axis]!)).join(' × ');
    const shape = [
      `${countText(vertices)} vertices`,
      `${countText(faces)} ${faces === 1 ? 'face' : 'faces'}`,
      ...(components > 1 ? [`${countText(components)} components`] : []),
      loops === 0 ? 'closed' : `${countText(loops)} ${loops === 1 ? 'boundary' : 'boundaries'}`,
    ];
    const { scale, up } = about.import;
    const read = [scale === undefined ? '' : `scaled by ${scale}`, up === undefined ? '' : `${up} was up`].filter(Boolean);
    facts.append(shape.join(' · '), element('br'), [`${size} ${unitOf(about)}`, ...read].join(' · '));
    warnings.replaceChildren(...about.warnings.map((text) => element('li', null, text)));
  };
  results.listen((now, before) => {
    if (now.meshes !== before.meshes) list();
    if (now.surface !== before.surface) tell(now.surface?.about);
  });
  state.listen((now, before) => {
    if (now.mesh !== before.mesh) select.value = now.mesh ?? '';
  });
  list();
  return root;
}
