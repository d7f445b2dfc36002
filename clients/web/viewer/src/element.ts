/**
 * Makes DOM elements in one expression. Styles are set by class only: the page's policy
 * allows no style attributes.
 */

type Child = Node | string | null | undefined | false;
type Properties<Tag extends keyof HTMLElementTagNameMap> = Partial<
  Omit<HTMLElementTagNameMap[Tag], 'style' | 'children' | 'dataset' | 'role'>
> & { aria?: Record<string, string>; role?: string };

/** `element('button', { className: 'quiet', onclick }, 'Keep')`; `aria` become aria-* attributes. */
export function element<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Properties<Tag> | null = null,
  ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const { aria, role, ...own } = properties ?? ({} as Properties<Tag>);
  const made = document.createElement(tag);
  Object.assign(made, own);
  if (role) made.setAttribute('role', role);
  for (const [name, value] of Object.entries(aria ?? {})) made.setAttribute(`aria-${name}`, value);
  for (const child of children) if (child) made.append(child);
  return made;
}

const SVG = 'http://www.w3.org/2000/svg';

/** A 20-pixel line drawing in the text's colour, from the `d` of a path; hidden from readers of the screen. */
export function icon(path: string): SVGSVGElement {
  const drawing = document.createElementNS(SVG, 'svg');
  drawing.setAttribute('viewBox', '0 0 20 20');
  drawing.setAttribute('aria-hidden', 'true');
  drawing.classList.add('icon');
  const line = document.createElementNS(SVG, 'path');
  line.setAttribute('d', path);
  drawing.append(line);
  return drawing;
}
