/**
 * Labels: short texts that stand at places of the surface, above them on the page. Where two are close one is
 * hidden, and those behind the surface are faint.
 */
import type { Vector3 } from 'three';
import { element } from './element.ts';
import type { Picking } from './picking.ts';
import type { Stage } from './stage.ts';

export interface Label {
  readonly text: string;
  readonly place: Vector3;
  readonly strong: boolean;
  /** Whether it stays as it is while the path is out of date. */
  readonly kept?: boolean;
}

/** CSS pixels that two labels are apart at least, in one of the two ways. */
const APART = { x: 46, y: 24 };

export class Labels {
  readonly #layer = element('div', { className: 'labels', aria: { hidden: 'true' } });
  #shown: { label: Label; tag: HTMLElement }[] = [];

  constructor(
    private readonly stage: Stage,
    private readonly picking: Picking,
  ) {
    document.body.append(this.#layer);
    stage.beforeFrame(() => this.#place());
  }

  set stale(stale: boolean) {
    this.#layer.classList.toggle('stale', stale);
  }

  show(labels: readonly Label[]): void {
    // Tags are used again: the path changes with every movement of a pointer.
    while (this.#shown.length > labels.length) this.#shown.pop()!.tag.remove();
    this.#shown = labels.map((label, index) => {
      const tag = this.#shown[index]?.tag ?? this.#layer.appendChild(element('span'));
      if (tag.textContent !== label.text) tag.textContent = label.text;
      tag.classList.toggle('strong', label.strong);
      tag.classList.toggle('kept', label.kept ?? false);
      return { label, tag };
    });
  }

  /** Those that are seen, for an export that draws them. */
  get texts(): { text: string; x: number; y: number; strong: boolean }[] {
    return this.#shown.flatMap(({ label, tag }) => {
      const at = tag.hidden || tag.classList.contains('behind') ? null : this.stage.onPage(label.place);
      return at ? [{ text: label.text, strong: label.strong, ...at }] : [];
    });
  }

  #place(): void {
    const taken: { x: number; y: number }[] = [];
    // Where labels are close the strong ones stand, and of the others the first.
    const inOrder = [...this.#shown].sort((a, b) => Number(b.label.strong) - Number(a.label.strong));
    for (const { label, tag } of inOrder) {
      const at = this.stage.onPage(label.place);
      tag.hidden = !at || taken.some(({ x, y }) => Math.abs(x - at.x) < APART.x && Math.abs(y - at.y) < APART.y);
      if (!at || tag.hidden) continue;
      taken.push(at);
      tag.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px) translate(-50%, -160%)`;
      tag.classList.toggle('behind', this.picking.hides(label.place, this.stage.camera));
    }
  }
}
