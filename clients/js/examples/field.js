/** A three.js mesh, coloured by distance, with isolines and the path to the farthest vertex. */
import * as THREE from 'three';
import { GeodesicClient } from 'geodesicd-client';
import { isolinesToSegments, pathToLine, setColours } from 'geodesicd-client/three';

const client = new GeodesicClient(new URLSearchParams(location.search).get('server') ?? location.origin);
const geometry = new THREE.TorusKnotGeometry(1, 0.36, 400, 64);
// Any BufferGeometry. This one has seams of nearly equal vertices, which are joined for distances.
const mesh = await client.upload(geometry, { reading: { weld: 1e-6 } });

const field = await client.distance(mesh.id, { from: 4000 }); // a number for each vertex of the geometry
setColours(geometry, field.values, { map: 'turbo' });
const lines = await client.isolines(mesh.id, { from: 4000, count: 24 });
const path = await client.path(mesh.id, { from: 4000, to: field.farthest, refine: 'shortest' });

const scene = new THREE.Scene();
scene.background = new THREE.Color(0xf2f4f7);
// The surface steps back a little, so that lines on it are seen.
const offset = { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 4 };
scene.add(new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ vertexColors: true, roughness: 0.7, ...offset })));
scene.add(isolinesToSegments(lines), pathToLine(path, new THREE.LineBasicMaterial({ color: 0xffffff })));
scene.add(new THREE.HemisphereLight(0xffffff, 0x888888, 2.6));

const camera = new THREE.PerspectiveCamera(40, innerWidth / innerHeight, 0.1, 100);
camera.position.set(0, 0, 5.6);
const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.setPixelRatio(devicePixelRatio);
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);
renderer.render(scene, camera);
