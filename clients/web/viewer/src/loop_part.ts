/** The panel's part for the line that is drawn: how it closes, how long it is, and why where it is none. */
import type { Across } from './drawing.ts';
import { element } from './element.ts';
import { lengthText } from './numbers.ts';
import { choice } from './panel.ts';
import type { Parts } from './parts.ts';
import type { Results } from './results.ts';
import { drawnKey } from './shapes.ts';
import { byCost, differ, isPlanar, type Drawn, type State } from './state.ts';
import { unitOf } from './units.ts';

const ROUND: readonly { across: Across; label: string; title: string }[] = [
  { across: 'view', label: 'As seen', title: 'In the plane that is seen as a level line through the point' },
  { across: 'x', label: 'Across x', title: 'In the plane at a right angle to the x axis' },
  { across: 'y', label: 'Across y', title: 'In the plane at a right angle to the y axis' },
  { across: 'z', label: 'Across z', title: 'In the plane at a right angle to the z axis' },
];

const TITLES: Readonly<Record<Drawn['kind'], string>> = {
  open: 'Line', through: 'Loop through points', around: 'Tightened loop', plane: 'Tightened loop', tape: 'Tape',
};

export function loopPart({ state, results, actions }: Parts): HTMLElement {
  const title = element('h2', null);
  const big = element('output', { className: 'big', id: 'round' });
  const unit = element('span', { className: 'unit' });
  const said = element('p', { className: 'facts', id: 'loop-said', role: 'status' });
  const wall = element('button', { type: 'button', onclick: () => actions.use('wall'), title: 'A line that paths may not cross' }, 'Make it a wall');
  const curve = element('button', { type: 'button', onclick: () => actions.use('curve') }, 'Measure from it');
  const uses = element('div', { className: 'grid' }, wall, curve);
  const close = element('button', { type: 'button', onclick: actions.closeLoop, title: 'Back to the first point (J)' }, 'Close the loop');
  const number = element('div', { className: 'row' }, element('div', { className: 'number' }, big, unit), close);
  const byPoints = choice(
    'What a loop through points does',
    [
      { value: 'through', label: 'Through points', title: 'It goes through the points, and may bend there' },
      { value: 'around', label: 'Tightened', title: 'Let go like a rubber band; needs three points' },
    ] as const,
    (kind) => state.value.loop && state.set({ loop: { ...state.value.loop, kind } }),
  );
  const byPlane = choice(
    'What a loop in a plane does',
    [
      { value: 'plane', label: 'Tightened', title: 'A closed geodesic: it leaves the plane and slides to where it is shortest' },
      { value: 'tape', label: 'Tape', title: 'It stays in the plane and spans hollows' },
    ] as const,
    (kind) => state.value.loop && state.set({ loop: { ...state.value.loop, kind } }),
  );
  const round = element(
    'div',
    { className: 'stacked', role: 'group', aria: { labelledby: 'round-here' } },
    element('h3', { id: 'round-here' }, 'Tape round here, in the plane'),
    element('div', { className: 'four' }, ...ROUND.map(({ across, label, title: more }) =>
      element('button', { type: 'button', title: more, onclick: () => actions.roundHere(across) }, label))),
  );
  const root = element('section', { className: 'answer loop-part', hidden: true }, title, number, said, byPoints.root, byPlane.root, uses, round);

  const show = () => {
    const { loop, tool } = state.value;
    const { surface, drawn, noLoop, offers } = results.value;
    root.hidden = !loop && tool !== 'loop';
    if (root.hidden) return;
    const planar = loop !== null && isPlanar(loop);
    const count = loop?.points.length ?? 0;
    title.textContent = loop && (count > 1 || planar) ? TITLES[loop.kind] : 'Loop';
    root.classList.toggle('stale', loop !== null && !noLoop && drawn?.key !== drawnKey(state.value));
    number.hidden = !loop || (!planar && count < 2);
    const length = drawn?.length ?? null;
    big.textContent = noLoop ? '–' : !drawn ? '…' : length === null ? '∞' : lengthText(length);
    unit.textContent = drawn && length !== null && surface ? unitOf(surface.about) : '';
    said.textContent = saidOf(state.value, results.value);
    close.hidden = loop?.kind !== 'open' || count < 2;
    byPoints.root.hidden = !loop || loop.kind === 'open' || planar;
    if (loop?.kind === 'through' || loop?.kind === 'around') byPoints.set(loop.kind);
    const usable = loop !== null && (loop.kind === 'open' || loop.kind === 'through') && count > 1;
    wall.hidden = !offers.walls;
    curve.hidden = !offers.curves;
    // Least costs begin at points; what is painted next may have a weight.
    curve.disabled = byCost(state.value) || state.value.painted.as === 'weights';
    curve.title = curve.disabled ? 'Least costs begin at points, not at lines' : 'The line becomes a source';
    uses.hidden = !usable || !(offers.walls || offers.curves) || (loop.kind === 'through' && count < 3);
    byPoints.enable('around', count > 2);
    byPlane.root.hidden = !planar;
    if (loop?.kind === 'plane' || loop?.kind === 'tape') byPlane.set(loop.kind);
    round.hidden = count !== 1;
  };
  state.listen((now, before) => differ(now, before, 'loop', 'tool', 'walking', 'painted') && show());
  results.listen((now, before) => {
    if (differ(now, before, 'drawn', 'noLoop', 'offers', 'surface')) show();
  });
  show();
  return root;
}

function saidOf({ loop }: State, { drawn, noLoop }: Results): string {
  if (!loop) return 'Points one after the other, and back to the first; or one point, and a tape round it.';
  if (noLoop) return `No loop: ${noLoop}.`;
  if (!drawn) return '';
  if (drawn.length === null) return 'A point lies on another component: no path leads there.';
  // Of what was answered, which may be a moment behind the state.
  const { loop: answered } = drawn;
  if (!answered) return 'Shortest paths from point to point; not closed yet.';
  const facts = [];
  if (answered.hull) facts.push('In its plane, and straight over hollows');
  else if (answered.geodesic) facts.push('A closed geodesic');
  else if (answered.turn != null) facts.push(`Bends by ${lengthText(answered.turn)}° at most`);
  if (answered.hull) facts.push(`${lengthText(answered.start_length)} along the surface`);
  else if (answered.start !== 'through') facts.push(`${lengthText(answered.start_length)} before it was tightened`);
  return facts.join(' · ');
}
