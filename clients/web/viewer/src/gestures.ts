/**
 * Pointers and keys on the canvas: a click places what the tool says, a handle is dragged
 * along the surface, everything else moves the camera. The same by mouse, pen, finger and
 * keyboard; the keyboard places at the cross in the middle of the view.
 */
import { Vector3, Plane } from 'three';
import { element } from './element.ts';
import { closed, withPoints } from './drawing.ts';
import type { Overlay, Handle } from './overlay.ts';
import type { Painter } from './painter.ts';
import type { Hit, Picking } from './picking.ts';
import type { Stage } from './stage.ts';
import { MOST_SOURCES, MOST_VIA, type Spot, type State, type Store, type Tool } from './state.ts';
import type { Surface } from './surface.ts';

const STILL = 5; // CSS pixels that a click may move

export interface GestureOptions {
  readonly stage: Stage;
  readonly overlay: Overlay;
  readonly picking: Picking;
  readonly painter: Painter;
  readonly state: Store<State>;
  /** The state's mesh; null while another one is still drawn. */
  readonly surface: () => Surface | null;
  /** Told when a drag begins and ends. */
  readonly dragging: (handle: Handle | null) => void;
  /** Told that no more points of the tool's kind are taken. */
  readonly full: (tool: Tool) => void;
  /** Told where a mouse without buttons is, but for handles. */
  readonly hovering: (at: { x: number; y: number } | null) => void;
}

export class Gestures {
  #options: GestureOptions | null = null;
  #held: Handle | null = null;
  /** The points when the drag began. */
  #before: Pick<State, 'sources' | 'via' | 'target' | 'arrow' | 'loop'> | null = null;
  /** Whether a stroke of the brush goes on. */
  #painting = false;
  #pressed: { id: number; x: number; y: number; shift: boolean } | null = null;
  readonly #ring = element('div', { className: 'ring', hidden: true, aria: { hidden: 'true' } });
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
    canvas.addEventListener('pointerleave', () => { this.#ring.hidden = true; });
    canvas.addEventListener('dblclick', () => this.#close());
    canvas.addEventListener('keydown', (event) => this.#key(event));
    // Before other listeners: while a point is held, Escape means the drag.
    addEventListener('keydown', (event) => { if (event.key === 'Escape') this.#takeBack(event); }, { capture: true });
    canvas.addEventListener('focus', () => { this.#cross.hidden = !canvas.matches(':focus-visible'); });
    canvas.addEventListener('blur', () => { this.#cross.hidden = true; });
    document.body.append(this.#cross, this.#ring);
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
    if (!event.isPrimary || event.button !== 0) {
      if (this.#painting) this.#drop();
      return void (this.#pressed = null);
    }
    const { stage, overlay, dragging, painter, state } = this.#ready;
    this.#pressed = { id: event.pointerId, x: event.clientX, y: event.clientY, shift: event.shiftKey };
    if (state.value.tool === 'brush') {
      this.#painting = painter.begin(event.clientX, event.clientY, event.shiftKey !== state.value.erasing);
      // Of fingers the second one still means the camera.
      if (event.pointerType === 'touch') stage.controls.enableRotate = !this.#painting;
      else stage.controls.enabled = !this.#painting;
      if (this.#painting) stage.canvas.setPointerCapture(event.pointerId);
      return;
    }
    this.#held = overlay.handleAt(event.clientX, event.clientY, event.pointerType === 'touch');
    stage.controls.enabled = !this.#held;
    if (!this.#held) return;
    const { sources, via, target, arrow, loop } = state.value;
    this.#before = { sources, via, target, arrow, loop };
    stage.canvas.setPointerCapture(event.pointerId);
    overlay.hold(this.#held);
    dragging(this.#held);
  }

  #move(event: PointerEvent): void {
    if (!this.#options) return;
    const { stage, overlay, hovering, painter, state } = this.#ready;
    if (state.value.tool === 'brush') this.#showRing(event);
    else this.#ring.hidden = true;
    if (this.#painting && event.pointerId === this.#pressed?.id) return painter.move(event.clientX, event.clientY);
    if (state.value.tool === 'brush') return;
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
    const { state, painter } = this.#ready;
    if (this.#painting && pressed && event.pointerId === pressed.id) {
      this.#painting = false;
      painter.end();
    }
    this.#drop();
    if (!pressed || event.pointerId !== pressed.id || state.value.tool === 'brush') return;
    if (Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > STILL) return;
    if (held?.kind === 'loop' && held.index === 0 && state.value.tool === 'loop') this.#close();
    if (held) return;
    const hit = this.#hit(event.clientX, event.clientY);
    const tool = pressed.shift && state.value.tool === 'source' ? 'add' : state.value.tool;
    if (hit) this.place(tool, hit.spot);
  }

  /** Points stand where they stood before the drag. */
  #takeBack(event: KeyboardEvent): void {
    if (this.#painting) {
      event.preventDefault();
      return this.#drop();
    }
    if (!this.#held || !this.#options || !this.#before) return;
    event.preventDefault();
    this.#options.state.set(this.#before);
    this.#drop();
  }

  #drop(): void {
    this.#pressed = null;
    if (!this.#options) return;
    const { controls } = this.#options.stage;
    controls.enableRotate = controls.enabled = true;
    if (this.#painting) {
      this.#painting = false;
      this.#options.painter.takeBack();
    }
    if (!this.#held) return;
    this.#held = null;
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
    const { state, surface, full, painter } = this.#ready;
    const { sources, via, target, arrow, loop } = state.value;
    switch (tool) {
      case 'source':
        // The first source asks for a target: that is the next click.
        return state.set({ sources: [spot], ...(target ? {} : { tool: 'target' as const }) });
      case 'add':
        if (sources.length >= MOST_SOURCES) return full(tool);
        return state.set({ sources: [...sources, spot] });
      case 'target':
        return state.set({ target: spot });
      case 'via':
        if (via.length >= MOST_VIA) return full(tool);
        return state.set({ via: [...via, spot] });
      case 'loop': {
        const longer = withPoints(loop, [spot]);
        return longer.full ? full(tool) : state.set({ loop: longer.line });
      }
      case 'brush':
        return painter.dab(spot);
      case 'arrow': {
        const mesh = surface();
        if (!mesh) return;
        const length = arrow?.length ?? Number((0.8 * mesh.radius).toPrecision(3));
        return state.set({ arrow: { from: spot, direction: arrow?.direction ?? this.#rightward(mesh, spot), length } });
      }
    }
  }

  /** Closes the line that is drawn, while its tool is at hand; whether there was one to close. */
  #close(): boolean {
    const { tool, loop } = this.#ready.state.value;
    const made = tool === 'loop' && loop ? closed(loop) : loop;
    this.#ready.state.set({ loop: made });
    return made !== loop;
  }

  /** How large the brush is, where a mouse or a pen is above the mesh. */
  #showRing({ clientX, clientY, pointerType }: PointerEvent): void {
    const radius = pointerType === 'touch' ? null : this.#ready.painter.pixelsAt(clientX, clientY);
    this.#ring.hidden = radius === null;
    if (radius === null) return;
    this.#ring.style.width = this.#ring.style.height = `${2 * radius}px`;
    this.#ring.style.transform = `translate(${clientX - radius}px, ${clientY - radius}px)`;
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
    const { sources, via, arrow, loop } = state.value;
    const swapped = (spots: readonly Spot[]) => spots.map((old, index) => (index === handle.index ? spot : old));
    if (handle.kind === 'source') state.set({ sources: swapped(sources) });
    else if (handle.kind === 'via') state.set({ via: swapped(via) });
    else if (handle.kind === 'target') state.set({ target: spot });
    else if (handle.kind === 'loop') return void (loop && state.set({ loop: { ...loop, points: swapped(loop.points) } }));
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
    // Without the cross it ends what was drawn by clicks.
    if (event.key === 'Enter' && this.#cross.hidden && this.#close()) return;
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
