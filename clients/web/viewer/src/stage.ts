/**
 * The canvas with its camera and light: draws when something has changed and never
 * otherwise, so a page that lies in a background costs nothing.
 */
import {
  BufferAttribute, BufferGeometry, Mesh, PerspectiveCamera, Quaternion, Scene, Spherical, Vector3, WebGLRenderer,
  type Material, type Object3D,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import type { Axis } from './state.ts';

const UP: Record<Axis, Vector3> = { x: new Vector3(1, 0, 0), y: new Vector3(0, 1, 0), z: new Vector3(0, 0, 1) };
/** Whence a mesh is seen that is flat along an axis; a little aside where that axis is up. */
const STRAIGHT: Record<Axis, Vector3> = { x: new Vector3(1, 0, 0), y: new Vector3(0, 1, 0.001), z: new Vector3(0, 0, 1) };

const calm = matchMedia('(prefers-reduced-motion: reduce)');

/** CSS pixels at the sides of the page that the panel and the legend cover. */
export interface Covered {
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

/** There is nothing to draw with. */
export class NoWebGL extends Error {}

export class Stage {
  readonly canvas: HTMLCanvasElement;
  readonly camera = new PerspectiveCamera(35, 1, 0.01, 60);
  readonly scene = new Scene();
  controls: OrbitControls;
  readonly #renderer: WebGLRenderer;
  readonly #beforeFrame: ((now: number) => boolean | void)[] = [];
  #byHand = false;
  #rest = 0;
  #asked = false;
  readonly #turned: (() => void)[] = [];
  readonly #resized: ((width: number, height: number) => void)[] = [];
  #covered: Covered = { top: 0, right: 0, bottom: 0 };

  /** Throws NoWebGL where the browser has no WebGL 2. `first` gets the canvas's pointers before the camera does. */
  constructor(first: (canvas: HTMLCanvasElement) => void) {
    try {
      this.#renderer = new WebGLRenderer({ antialias: true, alpha: true, stencil: true, powerPreference: 'high-performance' });
    } catch (error) {
      throw new NoWebGL(String(error));
    }
    // To ask whether a shader compiled is to wait for it; ours are tested.
    this.#renderer.debug.checkShaderErrors = import.meta.env.DEV;
    this.#renderer.setClearColor(0, 0);
    this.canvas = this.#renderer.domElement;
    first(this.canvas);
    this.controls = this.#control();
    this.canvas.addEventListener('webglcontextrestored', () => this.wake());
    new ResizeObserver(() => this.#resize()).observe(document.documentElement);
  }

  #control(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    Object.assign(controls, {
      enableDamping: !calm.matches,
      dampingFactor: 0.14,
      rotateSpeed: 0.9,
      minDistance: 0.05,
      maxDistance: 20,
      zoomToCursor: true,
    });
    controls.addEventListener('start', () => { this.#byHand = true; });
    controls.addEventListener('change', () => {
      this.wake();
      // After a release the view glides on: it is told where it comes to rest.
      clearTimeout(this.#rest);
      if (this.#byHand) this.#rest = window.setTimeout(() => this.#turned.forEach((listener) => listener()), 200);
    });
    return controls;
  }

  /** To be told where the view has come to rest after its reader has moved it. */
  onTurned(listener: () => void): void {
    this.#turned.push(listener);
  }

  /** Which of the axes is up; controls know it from their making only. */
  setUp(axis: Axis): void {
    const up = UP[axis];
    if (up.equals(this.camera.up)) return;
    const target = this.controls.target.clone();
    this.camera.up.copy(up);
    this.controls.dispose();
    this.controls = this.#control();
    this.controls.target.copy(target);
  }

  /** To be run before each frame; one that answers true wants another frame. */
  beforeFrame(run: (now: number) => boolean | void): void {
    this.#beforeFrame.push(run);
  }

  get size(): { width: number; height: number } {
    return { width: innerWidth, height: innerHeight };
  }

  /** Moves the middle of the view to the middle of what is left free. */
  cover(covered: Covered): void {
    this.#covered = covered;
    this.#resize();
  }

  get covered(): Covered {
    return this.#covered;
  }

  #resize(): void {
    const { width, height } = this.size;
    this.#renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.#renderer.setSize(width, height);
    this.#frameFree(this.#covered);
    for (const listener of this.#resized) listener(width, height);
    this.wake();
  }

  /** Sees as much in the part of the page that is left free as a bare page would show. */
  #frameFree({ top, right, bottom }: Covered): void {
    const { width, height } = this.size;
    this.camera.aspect = width / height;
    // A narrow view sees as much in width as a wide one in height.
    const high = Math.max(1, height - top - bottom);
    const free = Math.max(0.2, (width - right) / high);
    this.camera.zoom = Math.min(1, free) * Math.max(0.3, high / height);
    this.camera.setViewOffset(width, height, right / 2, (bottom - top) / 2, width, height);
    this.camera.updateProjectionMatrix();
  }

  onResize(listener: (width: number, height: number) => void): void {
    this.#resized.push(listener);
  }

  wake(): void {
    if (this.#asked) return;
    this.#asked = true;
    requestAnimationFrame((now) => {
      this.#asked = false;
      this.#frame(now);
    });
  }

  #frame(now: number): void {
    let again = this.controls.update();
    for (const run of this.#beforeFrame) again = run(now) === true || again;
    if (this.scene.children.length) this.#renderer.render(this.scene, this.camera);
    if (again) this.wake();
  }

  /** Lets a material's shaders be compiled while the mesh is still on its way. */
  warm(material: Material): void {
    const speck = new BufferGeometry();
    speck.setAttribute('position', new BufferAttribute(new Float32Array(9), 3));
    speck.setAttribute('normal', new BufferAttribute(new Float32Array(9), 3));
    const mesh = new Mesh(speck, material);
    mesh.frustumCulled = false;
    this.#renderer.render(new Scene().add(mesh), this.camera);
    speck.dispose();
  }

  /**
   * What `take` makes of the view: drawn as if nothing covered the page, so that what is in the middle of its
   * free part is in the middle of the picture.
   */
  picture<T>(take: (view: HTMLCanvasElement) => T): T {
    this.#frameFree({ top: 0, right: 0, bottom: 0 });
    try {
      this.#renderer.render(this.scene, this.camera);
      return take(this.canvas);
    } finally {
      this.#frameFree(this.#covered);
      this.wake();
    }
  }

  add(...objects: Object3D[]): void {
    this.scene.add(...objects);
    this.wake();
  }

  remove(...objects: Object3D[]): void {
    this.scene.remove(...objects);
    this.wake();
  }

  /**
   * Looks at a mesh of radius 1 about the origin, whose box has these sides: from a corner,
   * or straight at a flat one unless `fromCorner`.
   */
  fit(sides: Vector3, axis: Axis, fromCorner: boolean): void {
    const most = Math.max(sides.x, sides.y, sides.z);
    const flat = (['x', 'y', 'z'] as const).find((side) => sides[side] < 0.02 * most);
    const low = sides.z < 0.75 * Math.min(sides.x, sides.y);
    this.setUp(axis);
    const from = flat && !fromCorner ? STRAIGHT[flat].clone() : new Vector3(0.6, 0.52, 1);
    // The corner is seen from above, whatever is up.
    if (from.x === 0.6 && axis === 'z') from.set(0.45, -1, low ? 0.95 : 0.5);
    if (from.x === 0.6 && axis === 'x') from.set(0.52, 0.6, 1);
    this.#byHand = false;
    this.camera.position.copy(from.setLength(3.5));
    this.controls.target.set(0, 0, 0);
    this.controls.update();
    this.wake();
  }

  get view(): number[] {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()];
  }

  set view(numbers: readonly number[]) {
    this.camera.position.fromArray(numbers as number[], 0);
    this.controls.target.fromArray(numbers as number[], 3);
    this.controls.update();
    this.wake();
  }

  /** Turns about the target, for keys; radians. */
  turn(across: number, up: number): void {
    this.#byHand = true;
    const upright = new Quaternion().setFromUnitVectors(this.camera.up, UP.y);
    const offset = this.camera.position.clone().sub(this.controls.target).applyQuaternion(upright);
    const place = new Spherical().setFromVector3(offset);
    place.theta -= across;
    place.phi = Math.min(Math.PI - 0.01, Math.max(0.01, place.phi - up));
    offset.setFromSpherical(place).applyQuaternion(upright.invert());
    this.camera.position.copy(offset.add(this.controls.target));
    this.controls.update();
    this.wake();
  }

  /** Nearer by a factor below 1, farther by one above. */
  dolly(factor: number): void {
    this.#byHand = true;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const length = Math.min(20, Math.max(0.05, offset.length() * factor));
    this.camera.position.copy(offset.setLength(length).add(this.controls.target));
    this.controls.update();
    this.wake();
  }

  /** Where a drawn place is on the page, in CSS pixels; null behind the eye. */
  onPage(place: Vector3): { x: number; y: number } | null {
    const at = place.clone().project(this.camera);
    if (at.z > 1 || at.z < -1) return null;
    const { width, height } = this.size;
    return { x: ((at.x + 1) / 2) * width, y: ((1 - at.y) / 2) * height };
  }
}

/** Whether its reader wants movements on the screen. */
export function wantsMotion(): boolean {
  return !calm.matches;
}
