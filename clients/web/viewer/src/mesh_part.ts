/** The panel's part for the mesh: which one, a file of one's own, and what is known of it. */
import type { MeshMetadata } from 'geodesicd-client';
import { element, icon } from './element.ts';
import { countText, lengthText } from './numbers.ts';
import type { Parts } from './parts.ts';
import { Surface } from './surface.ts';

const UPLOAD = 'M10 13V4M6 8l4-4 4 4M4 13v3h12v-3';

export function meshPart({ state, results, actions }: Parts): HTMLElement {
  const select = element('select', { id: 'mesh', onchange: () => actions.chooseMesh(select.value) });
  const facts = element('p', { className: 'facts' });
  const warnings = element('ul', { className: 'warnings', hidden: true });
  const root = element(
    'section',
    { className: 'mesh-part' },
    element('label', { className: 'out-of-sight', htmlFor: 'mesh' }, 'Mesh'),
    element(
      'div',
      { className: 'row' },
      select,
      element('button', { type: 'button', className: 'primary', onclick: actions.open, title: 'Or drop a file anywhere' }, icon(UPLOAD), 'Open'),
    ),
    facts,
    warnings,
  );

  const list = () => {
    const { meshes } = results.value;
    const names = meshes.map((about) => Surface.nameOf(about));
    const options = meshes.map((about, index) => {
      const twice = names.filter((name) => name === names[index]).length > 1;
      return element('option', { value: about.id }, twice ? `${names[index]} · ${countText(about.vertices)} · ${about.id.slice(0, 4)}` : names[index]!);
    });
    if (!meshes.length) options.push(element('option', { value: '' }, 'No mesh yet: open a file'));
    select.replaceChildren(...options);
    select.value = state.value.mesh ?? '';
  };
  const tell = (about: MeshMetadata | undefined) => {
    facts.replaceChildren();
    warnings.hidden = !about?.warnings.length;
    if (!about) return;
    const { vertices, faces, components, boundary_loops: loops } = about;
    const size = [0, 1, 2].map((axis) => lengthText(about.bbox.max[axis]! - about.bbox.min[axis]!)).join(' × ');
    const shape = [
      `${countText(vertices)} vertices`,
      `${countText(faces)} faces`,
      ...(components > 1 ? [`${countText(components)} components`] : []),
      loops === 0 ? 'closed' : `${countText(loops)} ${loops === 1 ? 'boundary' : 'boundaries'}`,
    ];
    facts.append(shape.join(' · '), element('br'), `${size} units`);
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
