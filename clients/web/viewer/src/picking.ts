/**
 * From a place on the screen to a place on the mesh, through a bounding-volume hierarchy:
 * some ten microseconds a ray. The hierarchy is built by a worker; whoever asks before it
 * is there is told null.
 */
import { DoubleSide, Raycaster, Triangle, Vector2, Vector3, type Camera } from 'three';
import { MeshBVH } from 'three-mesh-bvh';
import type { BvhOrder } from './bvh_worker.ts';
import { spotOf } from './spot_text.ts';
import type { Spot } from './state.ts';
import type { Surface } from './surface.ts';

export interface Hit {
  readonly spot: Spot;
  /** Where it is drawn. */
  readonly place: Vector3;
}

export class Picking {
  #surface: Surface | null = null;
  #bvh: MeshBVH | null = null;
  #worker: Worker | null = null;
  /** Ends the wait for the worker when nothing comes of it any more. */
  #settle: (picked: boolean) => void = () => undefined;
  readonly #caster = new Raycaster();

  /** Takes another mesh; resolves with whether it can be picked, or was dropped before. Rejects where the worker fails. */
  take(surface: Surface): Promise<boolean> {
    this.drop();
    this.#surface = surface;
    const worker = new Worker(new URL('./bvh_worker.ts', import.meta.url), { type: 'module' });
    this.#worker = worker;
    return new Promise((resolve, reject) => {
      this.#settle = resolve;
      worker.onmessage = ({ data }) => {
        this.#bvh = MeshBVH.deserialize(data, surface.geometry, { setIndex: false });
        worker.terminate();
        resolve(true);
      };
      worker.onerror = (event) => reject(new Error(event.message || 'its worker did not load'));
      const positions = (surface.geometry.getAttribute('position').array as Float32Array).slice();
      const triangles = surface.triangles.slice();
      const order: BvhOrder = { positions, triangles };
      worker.postMessage(order, [positions.buffer, triangles.buffer]);
    });
  }

  /** Nothing can be picked until another mesh is taken. */
  drop(): void {
    this.#worker?.terminate();
    this.#settle(false);
    this.#surface = this.#bvh = null;
  }

  /** The first hit under a place on the page (CSS pixels). */
  at(x: number, y: number, camera: Camera): Hit | null {
    const pointer = new Vector2((x / innerWidth) * 2 - 1, 1 - (y / innerHeight) * 2);
    this.#caster.setFromCamera(pointer, camera);
    return this.#first();
  }

  /** Whether the surface is between the eye and a drawn place. */
  hides(place: Vector3, camera: Camera): boolean {
    const towards = place.clone().sub(camera.position);
    const distance = towards.length();
    this.#caster.set(camera.position, towards.normalize());
    const hit = this.#first();
    return hit !== null && hit.place.distanceTo(camera.position) < distance * 0.99;
  }

  /** The ray through a place on the page. */
  rayAt(x: number, y: number, camera: Camera) {
    this.#caster.setFromCamera(new Vector2((x / innerWidth) * 2 - 1, 1 - (y / innerHeight) * 2), camera);
    return this.#caster.ray;
  }

  #first(): Hit | null {
    const hit = this.#bvh?.raycastFirst(this.#caster.ray, DoubleSide);
    if (!hit || hit.faceIndex == null || !this.#surface) return null;
    const position = this.#surface.geometry.getAttribute('position');
    const [a, b, c] = this.#surface
      .cornersOf(hit.faceIndex)
      .map((vertex) => new Vector3().fromBufferAttribute(position, vertex));
    const bary = Triangle.getBarycoord(hit.point, a!, b!, c!, new Vector3());
    if (!bary) return null;
    return { spot: spotOf(hit.faceIndex, bary.x, bary.y), place: hit.point };
  }
}
