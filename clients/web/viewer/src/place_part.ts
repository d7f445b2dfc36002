/**
 * The panel's part for one place: what the last point stands on, points by the number of a
 * vertex or by coordinates, and many sources out of a text file.
 */
import { element } from './element.ts';
import { coordinateText, countText } from './numbers.ts';
import type { Parts } from './parts.ts';
import { surfaceOf } from './results.ts';
import type { Spot, State } from './state.ts';

const NAMES = { source: 'source', add: 'source', target: 'target', via: 'via point', arrow: 'arrow', loop: 'point of a loop', brush: 'dab of the brush' } as const;

/** What may be typed. */
const HOW = '12 or v:12: a vertex\nx y z or p:x,y,z: a place\nf:FACE,b1,b2: a point in a face\nSeveral: with ; between them';

/** The point that changed last, by its name. */
function changed(now: State, before: State): { name: string; spot: Spot } | null {
  const moved = now.sources.findIndex((spot, index) => spot !== before.sources[index]);
  if (now.sources !== before.sources && moved >= 0) {
    return { name: now.sources.length > 1 ? `Source ${moved + 1}` : 'Source', spot: now.sources[moved]! };
  }
  if (now.target && now.target !== before.target) return { name: 'Target', spot: now.target };
  const via = now.via.findIndex((spot, index) => spot !== before.via[index]);
  if (now.via !== before.via && via >= 0) return { name: 'Via', spot: now.via[via]! };
  if (now.arrow && now.arrow.from !== before.arrow?.from) return { name: 'Arrow', spot: now.arrow.from };
  const drawn = now.loop?.points ?? [];
  const joint = drawn.findIndex((spot, index) => spot !== before.loop?.points[index]);
  if (now.loop !== before.loop && joint >= 0) return { name: 'Loop', spot: drawn[joint]! };
  return null;
}

export function placePart({ state, results, actions }: Parts): HTMLElement {
  const told = element('p', { className: 'facts', id: 'place', hidden: true });
  const input = element('input', { type: 'text', id: 'vertex', autocomplete: 'off', placeholder: '12 or x y z', title: HOW });
  // Line ends would be taken away, and two numbers become one.
  input.onpaste = (event) => {
    const pasted = event.clipboardData?.getData('text').trim() ?? '';
    if (!/[\r\n]/.test(pasted)) return;
    event.preventDefault();
    input.setRangeText(pasted.replace(/\s*[\r\n]+\s*/g, '; '), input.selectionStart ?? 0, input.selectionEnd ?? 0, 'end');
  };
  const place = element('button', { type: 'submit' }, 'Place');
  const file = element('input', { type: 'file', accept: '.txt,.csv,text/plain,text/csv', hidden: true, tabIndex: -1, aria: { label: 'File of sources' } });
  file.onchange = () => {
    const [chosen] = file.files ?? [];
    file.value = '';
    if (chosen) actions.sourcesFrom(chosen);
  };
  const form = element(
    'form',
    {
      className: 'row place',
      onsubmit: (event: Event) => {
        event.preventDefault();
        const typed = input.value;
        void actions.placeTyped(typed).then((placed) => { if (placed && input.value === typed) input.value = ''; });
      },
    },
    element('label', { className: 'out-of-sight', htmlFor: 'vertex' }, 'Points: 12, x y z or f:FACE,b1,b2'),
    input,
    place,
    element('button', { type: 'button', title: 'A text file of sources: on each line a point, as here; after # a remark', onclick: () => file.click() }, 'File'),
    file,
  );
  const root = element('section', { className: 'place-part' }, told, form);
  const follow = () => {
    const name = `Place as ${NAMES[state.value.tool]}`;
    place.title = name;
    place.setAttribute('aria-label', name);
  };
  state.listen((now, before) => {
    follow();
    const surface = surfaceOf(now, results.value);
    const last = changed(now, before);
    if (now.mesh !== before.mesh || !(now.sources.length || now.target || now.via.length || now.arrow || now.loop)) told.hidden = true;
    if (!last) return;
    // Facts of the point before would be taken for this one's.
    told.hidden = !surface?.has(last.spot);
    if (!surface || told.hidden) return;
    const at = surface.xyzOf(last.spot).map((part) => coordinateText(part, surface.radius)).join(', ');
    const vertex = surface.vertexNear(last.spot);
    told.textContent = `${last.name}: ${vertex.on ? 'vertex' : 'near vertex'} ${countText(vertex.number)}, face ${countText(last.spot.face)}, at (${at})`;
  });
  follow();
  return root;
}
