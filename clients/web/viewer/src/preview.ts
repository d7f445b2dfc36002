/** What has come of a large mesh, drawn until all of it is there. */
import { BufferAttribute, BufferGeometry, DoubleSide, GLSL3, Mesh, ShaderMaterial, Vector3 } from 'three';
import type { ArrivingGeometry, MeshMetadata } from 'geodesicd-client';
import { placementOf } from './surface.ts';
import type { Stage } from './stage.ts';

/** Milliseconds from one picture to the next: faces that come go to the graphics card. */
const PAUSE = 100;

/** Smaller meshes are there before one could look. */
const LARGE = 200_000; // faces

export class Preview {
  readonly #mesh = new Mesh<BufferGeometry, ShaderMaterial>(undefined, clay());
  #triangles: Uint32Array | null = null;
  #arrived = 0; // faces
  #drawn = 0; // of these
  #next = 0; // timer of the next picture

  /** `begin` is called once a try, with the box of what is drawn, before the first picture. */
  constructor(
    private readonly stage: Stage,
    private readonly begin: (about: MeshMetadata, sides: Vector3) => void,
  ) {}

  show(about: MeshMetadata, { positions, triangles, faces }: ArrivingGeometry): void {
    if (about.faces < LARGE) return;
    // Other arrays are those of another mesh, or of another try after the network failed.
    if (this.#triangles !== triangles) this.#take(about, positions, triangles);
    this.#arrived = faces;
    this.#next ||= window.setTimeout(() => this.#draw(), this.#drawn ? PAUSE : 0);
  }

  end(): void {
    clearTimeout(this.#next);
    this.#next = 0;
    this.stage.remove(this.#mesh);
    this.#mesh.geometry.dispose();
    this.#mesh.geometry = new BufferGeometry();
    this.#triangles = null;
    delete document.body.dataset['preview'];
  }

  #draw(): void {
    this.#next = 0;
    const index = this.#mesh.geometry.getIndex()!;
    index.addUpdateRange(3 * this.#drawn, 3 * (this.#arrived - this.#drawn));
    index.needsUpdate = true;
    this.#drawn = this.#arrived;
    this.#mesh.geometry.setDrawRange(0, 3 * this.#drawn);
    document.body.dataset['preview'] = String(this.#drawn);
    this.stage.wake();
  }

  #take(about: MeshMetadata, positions: Float64Array, triangles: Uint32Array): void {
    this.end();
    const { drawn, box } = placementOf(positions, null); // most of its faces are still to come
    const { geometry } = this.#mesh;
    geometry.setAttribute('position', new BufferAttribute(drawn, 3));
    geometry.setIndex(new BufferAttribute(triangles, 1));
    geometry.computeBoundingSphere();
    geometry.setDrawRange(0, 0);
    this.#triangles = triangles;
    this.#arrived = this.#drawn = 0;
    this.stage.add(this.#mesh);
    this.begin(about, box.getSize(new Vector3()));
  }
}

/** Faces in grey, by their own normals: those of vertices would need all faces. */
function clay(): ShaderMaterial {
  return new ShaderMaterial({
    glslVersion: GLSL3,
    side: DoubleSide,
    vertexShader: /* glsl */ `
      out vec3 vPlace;
      void main() {
        vec4 place = modelViewMatrix * vec4(position, 1.0);
        vPlace = place.xyz;
        gl_Position = projectionMatrix * place;
      }`,
    fragmentShader: /* glsl */ `
      in vec3 vPlace;
      out vec4 colour;
      void main() {
        vec3 across = cross(dFdx(vPlace), dFdy(vPlace));
        float facing = abs(across.z) / max(length(across), 1e-20);
        colour = vec4(vec3(0.6, 0.62, 0.66) * (0.4 + 0.6 * facing), 1.0);
      }`,
  });
}
