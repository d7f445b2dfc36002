/**
 * A mesh as the page holds it: the server's geometry, which queries speak of by vertex and
 * face, and the same moved and scaled to radius 1 about the origin for drawing. Positions
 * stay float64 until they are centred, so a mesh far from its origin does not tremble.
 */
import { BufferAttribute, BufferGeometry, Vector3 } from 'three';
import type { MeshMetadata } from 'geodesicd-client';
import type { Spot, Xyz } from './state.ts';

export class Surface {
  readonly geometry = new BufferGeometry();
  /** Mesh units of one drawn unit. */
  readonly radius: number;
  readonly middle: Xyz;
  readonly triangles: Uint32Array;

  constructor(
    readonly about: MeshMetadata,
    positions: Float64Array,
    triangles: Uint32Array,
  ) {
    const { min, max } = about.bbox;
    this.middle = [0, 1, 2].map((axis) => (min[axis]! + max[axis]!) / 2) as unknown as Xyz;
    this.radius = radiusOf(positions, this.middle) || 1;
    this.triangles = triangles;
    const drawn = new Float32Array(positions.length);
    for (let i = 0; i < positions.length; i++) {
      drawn[i] = (positions[i]! - this.middle[i % 3]!) / this.radius;
    }
    this.geometry.setAttribute('position', new BufferAttribute(drawn, 3));
    this.geometry.setIndex(new BufferAttribute(triangles, 1));
    this.geometry.computeVertexNormals();
    this.geometry.computeBoundingSphere();
  }

  get id(): string {
    return this.about.id;
  }

  /** A name for people: the file's own, else its kind. */
  static nameOf(about: MeshMetadata): string {
    const named = about.parts.find((part) => part.name)?.name;
    return named ? named.replaceAll('_', ' ') : `unnamed ${about.id.slice(0, 6)}`;
  }

  /** Whether the face exists; a link may speak of another mesh. */
  has(spot: Spot): boolean {
    return spot.face < this.about.faces;
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

/** The distance from the middle to the farthest vertex. */
function radiusOf(positions: Float64Array, [x, y, z]: Xyz): number {
  let most = 0;
  for (let i = 0; i < positions.length; i += 3) {
    const [dx, dy, dz] = [positions[i]! - x, positions[i + 1]! - y, positions[i + 2]! - z];
    most = Math.max(most, dx * dx + dy * dy + dz * dz);
  }
  return Math.sqrt(most);
}
