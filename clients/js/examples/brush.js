/**
 * A texture brush whose tip lies on the surface: its radius is measured along it, so paint does
 * not leap from one finger of a hand to the next. Paints while a button is held; the wheel sets
 * the radius. `?server=` is the server, `?mesh=` the mesh's id (else the first of the list).
 */
import * as THREE from 'three';
import { GeodesicClient } from 'geodesicd-client';
import { setField } from 'geodesicd-client/three';

const asked = new URLSearchParams(location.search);
const client = new GeodesicClient(asked.get('server') ?? location.origin);
const mesh = await client.mesh(asked.get('mesh') ?? (await client.list())[0].id);
const { positions, triangles } = await client.geometry(mesh.id);

const geometry = new THREE.BufferGeometry();
geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(positions), 3));
geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
geometry.computeVertexNormals();
geometry.computeBoundingSphere();
const { center, radius: size } = geometry.boundingSphere;
export const paint = setField(geometry, new Float32Array(mesh.vertices), 'paint');
setField(geometry, new Float32Array(mesh.vertices).fill(1e9), 'reach');

export const brush = { value: size / 8 }; // its radius, mesh units
const material = new THREE.MeshStandardMaterial({ color: 0xb8b0a8, side: THREE.DoubleSide });
material.onBeforeCompile = (shader) => {
  shader.uniforms.brush = brush;
  shader.vertexShader = shader.vertexShader
    .replace('void main() {', 'attribute float paint, reach; varying float vPaint, vReach; void main() { vPaint = paint; vReach = reach;');
  shader.fragmentShader = shader.fragmentShader
    .replace('void main() {', 'uniform float brush; varying float vPaint, vReach; void main() {')
    .replace('#include <color_fragment>', `diffuseColor.rgb = mix(diffuseColor.rgb, vec3(0.8, 0.1, 0.2), smoothstep(0.0, 0.5, vPaint));
      float rim = abs(vReach - brush) / max(fwidth(vReach), 1e-6); // the tip's outline, two pixels wide
      diffuseColor.rgb = mix(vec3(0.0), diffuseColor.rgb, clamp(rim - 1.0, 0.0, 1.0));`);
};
const scene = new THREE.Scene().add(new THREE.Mesh(geometry, material), new THREE.HemisphereLight(0xffffff, 0x606060, 3));
const renderer = new THREE.WebGLRenderer({ antialias: true });
document.body.append(renderer.domElement);
renderer.setSize(innerWidth, innerHeight);
const camera = new THREE.PerspectiveCamera(40, innerWidth / innerHeight, size / 100, size * 10);
camera.position.copy(center).add(new THREE.Vector3(0, 0, 3 * size));
renderer.setAnimationLoop(() => renderer.render(scene, camera));

let busy = false; // one question at a time: the next one is where the mouse is then
renderer.domElement.addEventListener('pointermove', async ({ clientX, clientY, buttons }) => {
  if (busy) return;
  busy = true;
  const { ray } = new THREE.Raycaster();
  ray.origin.copy(camera.position);
  ray.direction.set((2 * clientX) / innerWidth - 1, 1 - (2 * clientY) / innerHeight, 0.5).unproject(camera).sub(ray.origin).normalize();
  const from = { ray: { origin: ray.origin.toArray(), direction: ray.direction.toArray() } };
  const max = brush.value + 2 * mesh.mean_edge; // what is farther is as far, so that no second outline is drawn
  const field = await client.distance(mesh.id, { from, max }).catch(() => null); // no hit
  if (field) setField(geometry, field.values.map((d) => Math.min(d, max)), 'reach');
  if (field && buttons) paint.array.forEach((p, v) => (paint.array[v] = Math.max(p, 1 - field.values[v] / brush.value)));
  paint.needsUpdate = true;
  busy = false;
});
addEventListener('wheel', ({ deltaY }) => (brush.value *= Math.exp(-deltaY / 1000)));
