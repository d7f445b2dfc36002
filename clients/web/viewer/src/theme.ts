/** Dark and light: as the system says, until the switch says otherwise. */
import { Kept } from './storage.ts';

export type Theme = 'light' | 'dark';
const KEPT = new Kept('localStorage', 'geodesicd-theme');
const CLAY: Record<Theme, string> = { light: '#cdc6bd', dark: '#a39e98' };

export class ThemeSwitch {
  readonly #system = matchMedia('(prefers-color-scheme: dark)');
  readonly #changed: (clay: string) => void;

  /** `changed` is told the colour of the clay, at once and with every change. */
  constructor(changed: (clay: string) => void) {
    this.#changed = changed;
    this.#system.addEventListener('change', () => this.#apply());
    this.#apply();
  }

  get theme(): Theme {
    const kept = KEPT.value;
    if (kept === 'light' || kept === 'dark') return kept;
    return this.#system.matches ? 'dark' : 'light';
  }

  toggle(): void {
    KEPT.value = this.theme === 'dark' ? 'light' : 'dark';
    this.#apply();
  }

  #apply(): void {
    document.documentElement.dataset['theme'] = this.theme;
    this.#changed(CLAY[this.theme]);
  }
}
