/**
 * Pointers and keys on the canvas: a click places what the tool says, a handle is dragged
 * along the surface, everything else moves the camera. The same by mouse, pen, finger and
 * keyboard; the keyboard places at the cross in the middle of the view.
 */
import { Vector3, Plane } from 'three';
import { element } from './element.ts';
import type { Overlay, Handle } from './overlay.ts';
import type { Hit, Picking } from './picking.ts';
import type { Stage } from './stage.ts';
import { MOST_SOURCES, type Spot, type State, type Store, type Tool } from './state.ts';
import type { Surface } from './surface.ts';

const STILL = 5; // CSS pixels that a click may move

export interface GestureOptions {
  readonly stage: Stage;
  readonly overlay: Overlay;
  readonly picking: Picking;
  readonly state: Store<State>;
  /** The state's mesh; null while another one is still drawn. */
  readonly surface: () => Surface | null;
  /** Told when a drag begins and ends. */
  readonly dragging: (handle: Handle | null) => void;
  readonly full: () => void;
  /** Told where a mouse without buttons is, but for handles. */
  readonly hovering: (at: { x: number; y: number } | null) => void;
}

export class Gestures {
  #options: GestureOptions | null = null;
  #held: Handle | null = null;
  /** The points when the drag began. */
  #before: Pick<State, 'sources' | 'via' | 'target' | 'arrow'> | null = null;
  #pressed: { id: number; x: number; y: number; shift: boolean } | null = null;
  readonly #cross = element('div', { className: 'cross', hidden: true, aria: { hidden: 'true' } });

  /** To be attached before the camera's controls, so that a held handle stops them. */
  attach(canvas: HTMLCanvasElement): void {
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'application');
    canvas.setAttribute('aria-label', 'Mesh. Arrow keys turn it, plus and minus zoom, Enter places a point in the middle of the view.');
    canvas.addEventListener('pointerdown', (event) => this.#down(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    canvas.addEventListener('pointerup', (event) => this.#up(event));
    canvas.addEventListener('pointercancel', () => this.#drop());
    canvas.addEventListener('keydown', (event) => this.#key(event));
    // Before other listeners: while a point is held, Escape means the drag.
    addEventListener('keydown', (event) => { if (event.key === 'Escape') this.#takeBack(event); }, { capture: true });
    canvas.addEventListener('focus', () => { this.#cross.hidden = !canvas.matches(':focus-visible'); });
    canvas.addEventListener('blur', () => { this.#cross.hidden = true; });
    document.body.append(this.#cross);
  }

  use(options: GestureOptions): void {
    this.#options = options;
  }

  get #ready(): GestureOptions {
    if (!this.#options) throw new Error('gestures before use()');
    return this.#options;
  }

  #down(event: PointerEvent): void {
    if (!this.#options) return;
    this.#cross.hidden = true;
    // A second finger means the camera.
    if (!event.isPrimary || event.button !== 0) return void (this.#pressed = null);
    const { stage, overlay, dragging } = this.#ready;
    this.#pressed = { id: event.pointerId, x: event.clientX, y: event.clientY, shift: event.shiftKey };
    this.#held = overlay.handleAt(event.clientX, event.clientY, event.pointerType === 'touch');
    stage.controls.enabled = !this.#held;
    if (!this.#held) return;
    const { sources, via, target, arrow } = this.#ready.state.value;
    this.#before = { sources, via, target, arrow };
    stage.canvas.setPointerCapture(event.pointerId);
    overlay.hold(this.#held);
    dragging(this.#held);
  }

  #move(event: PointerEvent): void {
    if (!this.#options) return;
    const { stage, overlay, hovering } = this.#ready;
    if (this.#held && event.pointerId === this.#pressed?.id) return this.#drag(this.#held, event);
    if (event.pointerType === 'mouse' && event.buttons === 0) {
      const over = overlay.handleAt(event.clientX, event.clientY, false);
      stage.canvas.classList.toggle('over-handle', over !== null);
      hovering(over ? null : { x: event.clientX, y: event.clientY });
    }
  }

  #up(event: PointerEvent): void {
    if (!this.#options) return;
    const pressed = this.#pressed;
    const held = this.#held;
    this.#drop();
    if (!pressed || held || event.pointerId !== pressed.id) return;
    if (Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > STILL) return;
    const { state } = this.#ready;
    const hit = this.#hit(event.clientX, event.clientY);
    const tool = pressed.shift && state.value.tool === 'source' ? 'add' : state.value.tool;
    if (hit) this.place(tool, hit.spot);
  }

  /** Points stand where they stood before the drag. */
  #takeBack(event: KeyboardEvent): void {
    if (!this.#held || !this.#options || !this.#before) return;
    event.preventDefault();
    this.#options.state.set(this.#before);
    this.#drop();
  }

  #drop(): void {
    this.#pressed = null;
    if (!this.#held || !this.#options) return;
    this.#held = null;
    this.#options.stage.controls.enabled = true;
    this.#options.overlay.hold(null);
    this.#options.dragging(null);
  }

  /** What is under a place on the page; nothing while the mesh there is not the state's. */
  #hit(x: number, y: number): Hit | null {
    const { picking, stage, surface } = this.#ready;
    return surface() ? picking.at(x, y, stage.camera) : null;
  }

  /** Does with a place what the tool says. */
  place(tool: Tool, spot: Spot): void {
    const { state, surface, full } = this.#ready;
    const { sources, via, target, arrow } = state.value;
    switch (tool) {
      case 'source':
        // The first source asks for a target: that is the next click.
        return state.set({ sources: [spot], ...(target ? {} : { tool: 'target' as const }) });
      case 'add':
        if (sources.length >= MOST_SOURCES) return full();
        return state.set({ sources: [...sources, spot] });
      case 'target':
        return state.set({ target: spot });
      case 'via':
        return state.set({ via: [...via, spot] });
      case 'arrow': {
        const mesh = surface();
        if (!mesh) return;
        const length = arrow?.length ?? Number((0.8 * mesh.radius).toPrecision(3));
        return state.set({ arrow: { from: spot, direction: arrow?.direction ?? this.#rightward(mesh, spot), length } });
      }
    }
  }

  /** To the right of the view, in the face's plane. */
  #rightward(mesh: Surface, spot: Spot): [number, number, number] {
    const { camera } = this.#ready.stage;
    const direction = new Vector3().setFromMatrixColumn(camera.matrixWorld, 0).projectOnPlane(mesh.normalOf(spot.face));
    if (direction.lengthSq() < 1e-6) direction.setFromMatrixColumn(camera.matrixWorld, 1).projectOnPlane(mesh.normalOf(spot.face));
    return direction.normalize().toArray();
  }

  #drag(handle: Handle, event: PointerEvent): void {
    const { state } = this.#ready;
    if (handle.kind === 'tip') return this.#aim(event);
    const spot = this.#hit(event.clientX, event.clientY)?.spot;
    if (!spot) return; // beside the mesh it stays where it was last
    const { sources, via, arrow } = state.value;
    const swapped = (spots: readonly Spot[]) => spots.map((old, index) => (index === handle.index ? spot : old));
    if (handle.kind === 'source') state.set({ sources: swapped(sources) });
    else if (handle.kind === 'via') state.set({ via: swapped(via) });
    else if (handle.kind === 'target') state.set({ target: spot });
    else if (arrow) state.set({ arrow: { ...arrow, from: spot } });
  }

  /** Turns the arrow towards the pointer, in the plane of its face. */
  #aim(event: PointerEvent): void {
    const { picking, stage, state, overlay } = this.#ready;
    const { arrow } = state.value;
    const plane = overlay.arrowPlane();
    if (!arrow || !plane) return;
    const ray = picking.rayAt(event.clientX, event.clientY, stage.camera);
    const tangent = new Plane().setFromNormalAndCoplanarPoint(plane.normal, plane.start);
    const at = ray.intersectPlane(tangent, new Vector3());
    const towards = at?.sub(plane.start);
    if (!towards || towards.lengthSq() < 1e-12) return;
    state.set({ arrow: { ...arrow, direction: towards.normalize().toArray() } });
  }

  #key(event: KeyboardEvent): void {
    if (!this.#options || event.ctrlKey || event.metaKey || event.altKey) return;
    const { stage, state } = this.#ready;
    const turn = Math.PI / 36;
    const moves: Record<string, () => void> = {
      ArrowLeft: () => stage.turn(-turn, 0),
      ArrowRight: () => stage.turn(turn, 0),
      ArrowUp: () => stage.turn(0, turn),
      ArrowDown: () => stage.turn(0, -turn),
      '+': () => stage.dolly(1 / 1.15),
      '=': () => stage.dolly(1 / 1.15),
      '-': () => stage.dolly(1.15),
      Enter: () => {
        const { x, y } = this.middle;
        const hit = this.#hit(x, y);
        if (hit) this.place(state.value.tool, hit.spot);
      },
    };
    const move = moves[event.key];
    if (!move) return;
    event.preventDefault();
    this.#cross.hidden = false;
    move();
  }

  /** The middle of what is left free, on the page. */
  get middle(): { x: number; y: number } {
    const { width, height } = this.#ready.stage.size;
    const { top, right, bottom } = this.#ready.stage.covered;
    return { x: (width - right) / 2, y: (height + top - bottom) / 2 };
  }

  /** Puts the cross there. */
  centre(): void {
    const { x, y } = this.middle;
    this.#cross.style.transform = `translate(${x}px, ${y}px)`;
  }
}
