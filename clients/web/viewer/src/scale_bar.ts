/** A bar on the page that says how long a round length is, at the depth that the view turns about. */
import { element } from './element.ts';
import { tickText } from './numbers.ts';
import type { Stage } from './stage.ts';
import type { Surface } from './surface.ts';
import { unitOf } from './units.ts';

const LONGEST = 120; // CSS pixels

export class ScaleBar {
  readonly #bar = element('i', null);
  readonly #text = element('span', null);
  readonly #root = element('div', { className: 'scale', hidden: true, aria: { hidden: 'true' } }, this.#bar, this.#text);
  #surface: Surface | null = null;

  constructor(private readonly stage: Stage) {
    document.body.append(this.#root);
    stage.beforeFrame(() => this.#measure());
  }

  take(surface: Surface | null): void {
    this.#surface = surface;
    this.#root.hidden = surface === null;
    this.stage.wake();
  }

  #measure(): void {
    if (!this.#surface) return;
    const { pixels, text } = scaleOf(this.stage, this.#surface);
    this.#bar.style.width = `${pixels.toFixed(1)}px`;
    if (this.#text.textContent !== text) this.#text.textContent = text;
  }
}

/** A round length, and the CSS pixels that it has where the view turns about. */
export function scaleOf({ camera, controls, size }: Stage, surface: Surface): { pixels: number; text: string } {
  const away = camera.position.distanceTo(controls.target);
  const pixel = (2 * away * Math.tan((camera.fov * Math.PI) / 360)) / camera.zoom / size.height; // in drawn units
  const longest = LONGEST * pixel * surface.radius;
  const power = 10 ** Math.floor(Math.log10(longest));
  const length = power * (longest / power >= 5 ? 5 : longest / power >= 2 ? 2 : 1);
  return { pixels: length / surface.radius / pixel, text: `${tickText(length)} ${unitOf(surface.about)}` };
}
