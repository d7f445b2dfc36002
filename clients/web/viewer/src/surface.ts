/**
 * A mesh as the page holds it: the server's geometry, which queries speak of by vertex and
 * face, and the same moved and scaled to radius 1 about the origin for drawing. Positions
 * stay float64 until they are centred, so a mesh far from its origin does not tremble.
 */
import { Box3, BufferAttribute, BufferGeometry, Vector3 } from 'three';
import type { MeshMetadata } from 'geodesicd-client';
import type { Spot, Xyz } from './state.ts';

export class Surface {
  readonly geometry = new BufferGeometry();
  /** Mesh units of one drawn unit. */
  readonly radius: number;
  readonly middle: Xyz;
  readonly triangles: Uint32Array;

  constructor(
    /** As the server said it last: a mesh can get another name. */
    public about: MeshMetadata,
    positions: Float64Array,
    triangles: Uint32Array,
  ) {
    const { middle, radius, drawn, box } = placementOf(positions, triangles);
    this.middle = middle;
    this.radius = radius;
    this.triangles = triangles;
    this.geometry.setAttribute('position', new BufferAttribute(drawn, 3));
    this.geometry.setIndex(new BufferAttribute(triangles, 1));
    this.geometry.computeVertexNormals();
    this.geometry.boundingBox = box;
    this.geometry.computeBoundingSphere();
  }

  get id(): string {
    return this.about.id;
  }

  /** Whether the face exists; a link may speak of another mesh. */
  has(spot: Spot): boolean {
    return spot.face >= 0 && spot.face < this.about.faces;
  }

  cornersOf(face: number): [number, number, number] {
    const at = 3 * face;
    return [this.triangles[at]!, this.triangles[at + 1]!, this.triangles[at + 2]!];
  }

  /** Where a spot is drawn. */
  placeOf({ face, bary }: Spot, place = new Vector3()): Vector3 {
    const drawn = this.geometry.getAttribute('position').array;
    place.set(0, 0, 0);
    this.cornersOf(face).forEach((vertex, corner) => {
      place.x += bary[corner]! * drawn[3 * vertex]!;
      place.y += bary[corner]! * drawn[3 * vertex + 1]!;
      place.z += bary[corner]! * drawn[3 * vertex + 2]!;
    });
    return place;
  }

  /** Where a spot is, in mesh units. */
  xyzOf(spot: Spot): Xyz {
    const { x, y, z } = this.placeOf(spot);
    return [x, y, z].map((part, axis) => part * this.radius + this.middle[axis]!) as unknown as Xyz;
  }

  /** The nearest corner of a spot's face, and whether the spot is on it. */
  vertexNear(spot: Spot): { number: number; on: boolean } {
    const place = this.placeOf(spot);
    const position = this.geometry.getAttribute('position');
    const corners = this.cornersOf(spot.face);
    const away = corners.map((vertex) => new Vector3().fromBufferAttribute(position, vertex).distanceTo(place));
    const nearest = away.indexOf(Math.min(...away));
    return { number: corners[nearest]!, on: spot.bary[nearest]! >= 1 - 1e-6 };
  }

  /** A vertex of the file as a place on a face of its; null where it has none. */
  spotAt(vertex: number): Spot | null {
    if (!Number.isInteger(vertex) || vertex < 0 || vertex >= this.about.vertices) return null;
    let corner = this.triangles.indexOf(vertex);
    if (corner < 0) {
      // Of vertices in one place the faces name the first.
      const drawn = this.geometry.getAttribute('position').array;
      const [x, y, z] = [drawn[3 * vertex], drawn[3 * vertex + 1], drawn[3 * vertex + 2]];
      corner = this.triangles.findIndex((other) => drawn[3 * other] === x && drawn[3 * other + 1] === y && drawn[3 * other + 2] === z);
    }
    if (corner < 0) return null;
    const bary = [0, 0, 0].map((_, index) => Number(index === corner % 3)) as [number, number, number];
    return { face: Math.floor(corner / 3), bary };
  }

  /** The face's normal by its winding, of length 1. */
  normalOf(face: number, normal = new Vector3()): Vector3 {
    const position = this.geometry.getAttribute('position');
    const [a, b, c] = this.cornersOf(face).map((v) => new Vector3().fromBufferAttribute(position, v));
    return normal.crossVectors(b!.sub(a!), c!.sub(a!)).normalize();
  }

  /** From mesh units to where it is drawn, x, y, z after x, y, z. */
  drawn(points: readonly { readonly xyz: readonly number[] }[]): Float32Array {
    const placed = new Float32Array(3 * points.length);
    points.forEach(({ xyz }, index) => {
      for (let axis = 0; axis < 3; axis++) {
        placed[3 * index + axis] = (xyz[axis]! - this.middle[axis]!) / this.radius;
      }
    });
    return placed;
  }

  dispose(): void {
    this.geometry.dispose();
  }
}

export interface Placement {
  readonly middle: Xyz;
  readonly radius: number;
  /** The positions, moved and scaled. */
  readonly drawn: Float32Array;
  /** Of what is drawn. */
  readonly box: Box3;
}

/**
 * Where a mesh is drawn: its positions about the middle of its box, in parts of its radius (mesh units). Vertices
 * in no face are not seen and do not count, be they ever so far away; with no triangles given all count.
 */
export function placementOf(positions: Float64Array, triangles: Uint32Array | null): Placement {
  const counts = new Uint8Array(positions.length / 3).fill(triangles ? 0 : 1);
  for (const vertex of triangles ?? []) counts[vertex] = 1;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    if (!counts[Math.floor(i / 3)]) continue;
    low[i % 3] = Math.min(low[i % 3]!, positions[i]!);
    high[i % 3] = Math.max(high[i % 3]!, positions[i]!);
  }
  const [x, y, z] = low.map((least, axis) => (least + high[axis]!) / 2) as [number, number, number];
  let most = 0;
  for (let i = 0; i < positions.length; i += 3) {
    if (!counts[i / 3]) continue;
    const [dx, dy, dz] = [positions[i]! - x, positions[i + 1]! - y, positions[i + 2]! - z];
    most = Math.max(most, dx * dx + dy * dy + dz * dz);
  }
  const middle: Xyz = [x, y, z];
  const radius = Math.sqrt(most) || 1;
  const place = (value: number, axis: number) => (value - middle[axis]!) / radius;
  const drawn = new Float32Array(positions.length);
  for (let i = 0; i < positions.length; i++) drawn[i] = place(positions[i]!, i % 3);
  const box = new Box3(new Vector3().fromArray(low.map(place)), new Vector3().fromArray(high.map(place)));
  return { middle, radius, drawn, box };
}
