/**
 * The panel's part for a path's profile: height against the distance walked. Where one points
 * on the chart a dot stands on the mesh, and the other way round.
 */
import type { Path } from 'geodesicd-client';
import { element } from './element.ts';
import { coordinateText, lengthText, roundStep, tickText } from './numbers.ts';
import { part } from './panel.ts';
import type { Parts } from './parts.ts';
import { unitOf } from './units.ts';
import { upOf } from './upright.ts';

const WIDE = 284;
const HIGH = 120;
/** Of the drawing within: room for numbers at the left and below. */
const LEFT = 44;
const LOW = HIGH - 18;
const TOP = 8;
const RIGHT = WIDE - 8;

export interface Profile {
  /** Distance walked at each point, in mesh units. */
  readonly walked: readonly number[];
  readonly heights: readonly number[];
}

export function profileOf({ points }: Path, axis: number): Profile {
  let sum = 0;
  const walked = points.map(({ xyz }, index) => {
    const before = points[index - 1]?.xyz;
    if (before) sum += Math.hypot(...xyz.map((part, k) => part - before[k]!));
    return sum;
  });
  return { walked, heights: points.map(({ xyz }) => xyz[axis]!) };
}

export function heightAt({ walked, heights }: Profile, along: number): number {
  const next = walked.findIndex((each) => each >= along);
  if (next <= 0) return heights[next === 0 ? 0 : heights.length - 1]!;
  const part = (along - walked[next - 1]!) / (walked[next]! - walked[next - 1]! || 1);
  return heights[next - 1]! + part * (heights[next]! - heights[next - 1]!);
}

const SVG = 'http://www.w3.org/2000/svg';
function drawn(tag: string, attributes: Record<string, string | number>, text = ''): SVGElement {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, `${value}`);
  made.textContent = text;
  return made;
}

export function profilePart({ state, results }: Parts): HTMLElement {
  const chart = drawn('svg', { viewBox: `0 0 ${WIDE} ${HIGH}`, role: 'img', class: 'profile' }) as SVGSVGElement;
  const cursor = drawn('g', { class: 'cursor' });
  const slider = element('input', { type: 'range', min: '0', max: '1000', value: '0', aria: { label: 'Place along the path' } });
  const told = element('p', { className: 'facts', id: 'along' });
  const root = part('Profile', false, element('div', null, chart as unknown as HTMLElement), slider, told);
  root.hidden = true;
  let profile: Profile | null = null;
  let low = 0;
  let span = 1;

  const long = () => profile!.walked.at(-1)! || 1;
  const x = (walked: number) => LEFT + ((RIGHT - LEFT) * walked) / long();
  const y = (height: number) => LOW - ((LOW - TOP) * (height - low)) / span;

  const draw = () => {
    const { path, surface } = results.value;
    root.hidden = !path?.reachable;
    profile = null;
    if (!root.open || !path?.reachable || !surface) return;
    const axis = state.value.up ?? upOf(surface.about);
    const unit = unitOf(surface.about);
    profile = profileOf(path, 'xyz'.indexOf(axis));
    const { walked, heights } = profile;
    const least = Math.min(...heights);
    const most = Math.max(...heights);
    // What is flat is a line in the middle, not noise as high as the chart.
    span = Math.max(most - least, 0.02 * long());
    low = (least + most) / 2 - span / 2;
    const line = heights.map((height, index) => `${x(walked[index]!).toFixed(2)},${y(height).toFixed(2)}`).join(' ');
    const step = roundStep(long() / 4);
    const ticks: SVGElement[] = [];
    for (let n = 0; n * step <= long() * 0.9; n++) {
      ticks.push(drawn('text', { x: x(n * step), y: HIGH - 4, 'text-anchor': n ? 'middle' : 'start' }, tickText(n * step)));
    }
    for (const height of most - least < 0.02 * long() ? [least] : [least, most]) {
      ticks.push(drawn('text', { x: LEFT - 5, y: Math.min(LOW, Math.max(TOP + 6, y(height) + 4)), 'text-anchor': 'end' }, coordinateText(height, 100 * long())));
      ticks.push(drawn('line', { class: 'grid', x1: LEFT, x2: RIGHT, y1: y(height), y2: y(height) }));
    }
    chart.setAttribute('aria-label', `Height (${axis}) along the path: ${lengthText(long())} ${unit} long, from ${coordinateText(least, long())} to ${coordinateText(most, long())}`);
    chart.replaceChildren(
      ...ticks,
      drawn('polygon', { class: 'area', points: `${LEFT},${LOW} ${line} ${RIGHT},${LOW}` }),
      drawn('polyline', { class: 'line', points: line }),
      cursor,
    );
    point();
  };

  const point = () => {
    const { along, surface } = results.value;
    if (!profile || !surface) return;
    if (along === null) {
      cursor.replaceChildren();
      told.textContent = 'Point at the chart or at the path.';
      return;
    }
    const height = heightAt(profile, along);
    cursor.replaceChildren(
      drawn('line', { x1: x(along), x2: x(along), y1: TOP, y2: LOW }),
      drawn('circle', { cx: x(along), cy: y(height), r: 4 }),
    );
    slider.value = `${Math.round((1000 * along) / long())}`;
    const unit = unitOf(surface.about);
    const axis = state.value.up ?? upOf(surface.about);
    told.textContent = `${lengthText(along)} ${unit} along, ${axis} = ${coordinateText(height, surface.radius)} ${unit}`;
    slider.setAttribute('aria-valuetext', told.textContent);
  };

  chart.addEventListener('pointermove', (event) => {
    if (!profile) return;
    const box = chart.getBoundingClientRect();
    const at = ((event.clientX - box.left) / box.width) * WIDE;
    const part = Math.min(1, Math.max(0, (at - LEFT) / (RIGHT - LEFT)));
    results.set({ along: part * long() });
  });
  chart.addEventListener('pointerleave', () => results.set({ along: null }));
  slider.oninput = () => profile && results.set({ along: (Number(slider.value) / 1000) * long() });
  slider.onblur = () => results.set({ along: null });
  root.addEventListener('toggle', () => {
    results.set({ profiled: root.open });
    draw();
  });
  results.listen((now, before) => {
    if (now.path !== before.path) draw();
    else if (now.along !== before.along) point();
  });
  state.listen((now, before) => now.up !== before.up && draw());
  return root;
}
