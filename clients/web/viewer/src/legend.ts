/** The legend: which colour is which distance, with round numbers, or which source. */
import { colourAt, REGION_COLOURS, type ColourMap } from './colour_maps.ts';
import { element } from './element.ts';
import { lengthText, roundStep, shareText, tickText } from './numbers.ts';
import { hueOf } from './regions.ts';
import type { Results } from './results.ts';
import { byRegion, type State } from './state.ts';
import { lineStepOf } from './surface_view.ts';
import { SAID } from './costs.ts';

const BAR = 256; // colours across

/** What stands in the legend, for the page and for the exported picture alike. */
export interface LegendText {
  readonly title: string;
  readonly map: ColourMap | null;
  /** Labels with their places from 0 to 1; for regions the names instead. */
  readonly ticks: readonly { at: number; text: string; colour?: string }[];
  readonly note: string;
}

export function legendOf(state: State, { field, error, regions }: Results): LegendText | null {
  if (!field || !(field.max > 0)) return null;
  const step = lineStepOf(field.max, state.lines);
  const note = step > 0 ? `Lines every ${tickText(step)}` : '';
  if (byRegion(state.show) && field.labels) {
    const count = Math.min(field.sources, REGION_COLOURS.length);
    const ticks = Array.from({ length: count }, (_, index) => ({ at: 0, text: `${index + 1}`, colour: hueOf(regions, index) }));
    if (field.sources > count) return { title: `Nearest of ${field.sources}`, map: null, ticks: ticks.map((tick) => ({ ...tick, text: '' })), note };
    return { title: state.show === 'cells' ? 'Cells' : 'Nearest source', map: null, ticks, note };
  }
  if (state.show === 'error') {
    if (!error) return { title: 'Computing the exact distances …', map: 'magma', ticks: [], note: '' };
    const most = error.most;
    const ticks = most > 0 ? [0, 0.5, 1].map((at) => ({ at, text: shareText(at * most) })) : [{ at: 0, text: '0 %' }];
    return { title: 'Error against exact', map: 'magma', ticks, note: `Mean ${shareText(error.mean)}` };
  }
  const apart = roundStep(field.max / 4);
  const ticks = [];
  for (let n = 0; n * apart <= field.max * 0.78; n++) ticks.push({ at: (n * apart) / field.max, text: tickText(n * apart) });
  ticks.push({ at: 1, text: lengthText(field.max) });
  return { title: field.cost ? SAID[field.cost].field : 'Distance', map: state.colours, ticks, note };
}

/** CSS pixels at the top that are the legend's on a narrow page, whether it is there yet or not. */
export function roomForLegend(): number {
  return matchMedia('(max-width: 720px)').matches ? 84 : 0;
}

export class Legend {
  readonly #bar = element('canvas', { width: BAR, height: 1, aria: { hidden: 'true' } });
  readonly #title = element('h2', null);
  readonly #note = element('p', null);
  readonly #ticks = element('div', { className: 'ticks' });
  readonly #root = element('section', { className: 'legend', hidden: true }, this.#title, this.#bar, this.#ticks, this.#note);
  #map: ColourMap | null = null;

  constructor() {
    document.body.append(this.#root);
  }

  follow(state: State, results: Results): void {
    const said = legendOf(state, results);
    this.#root.hidden = !said;
    if (!said) return;
    this.#title.textContent = said.title;
    this.#note.textContent = said.note;
    this.#bar.hidden = said.map === null;
    if (said.map && said.map !== this.#map) this.#paint(said.map);
    this.#ticks.classList.toggle('regions', said.map === null);
    this.#ticks.replaceChildren(
      ...said.ticks.map(({ at, text, colour }) => {
        const tick = element('span', null, text);
        // The first and the last stay within the bar.
        if (said.map) {
          tick.style.left = `${100 * at}%`;
          tick.classList.add(at < 0.03 ? 'first' : at > 0.97 ? 'last' : 'between');
        }
        if (colour) tick.style.setProperty('--hue', colour);
        return tick;
      }),
    );
  }

  #paint(map: ColourMap): void {
    this.#map = map;
    const pen = this.#bar.getContext('2d')!;
    const row = pen.createImageData(BAR, 1);
    for (let x = 0; x < BAR; x++) row.data.set([...colourAt(map, x / (BAR - 1)), 255], 4 * x);
    pen.putImageData(row, 0, 0);
  }
}
