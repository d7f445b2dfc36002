// A geodesicd of a test's own with the built viewer and the samples, which can be stopped
// and started again on the same port; and requests to it apart from the page.
import { spawn } from 'node:child_process';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

const { GEODESICD, VIEWER_DIST, VIEWER_SAMPLES } = process.env;

export class Service {
  #process = null;
  #folder = null;
  #flags;
  port = 0;

  constructor(...flags) {
    this.#flags = flags;
  }

  get url() {
    return `http://127.0.0.1:${this.port}/`;
  }

  async start() {
    this.#folder ??= await mkdtemp(join(tmpdir(), 'viewer_'));
    const flags = ['--listen', `127.0.0.1:${this.port}`, '--store', join(this.#folder, 'store')];
    flags.push('--samples', VIEWER_SAMPLES, '--viewer', VIEWER_DIST, '--log-level', 'warn', ...this.#flags);
    this.#process = spawn(GEODESICD, flags, { stdio: ['ignore', 'pipe', 'inherit'] });
    for await (const line of createInterface({ input: this.#process.stdout })) {
      const port = /^listening on http:\/\/.*:(\d+)/.exec(line)?.[1];
      if (!port) continue;
      this.port = Number(port);
      return this;
    }
    throw new Error('geodesicd did not start');
  }

  /** Without a goodbye, as a power cut would. */
  async stop() {
    if (this.#process.exitCode !== null || this.#process.signalCode !== null) return;
    const ended = new Promise((resolve) => this.#process.once('exit', resolve));
    this.#process.kill('SIGKILL');
    await ended;
  }

  async end() {
    await this.stop();
    await rm(this.#folder, { recursive: true, force: true });
  }

  async json(path, options) {
    return (await fetch(new URL(path, this.url), options)).json();
  }

  /** How many jobs have ended so: done, failed, cancelled, refused. */
  async endedJobs(outcome) {
    const metrics = await (await fetch(new URL('/metrics', this.url))).text();
    return Number(new RegExp(`^geodesicd_jobs_total\\{outcome="${outcome}"\\} (\\d+)$`, 'm').exec(metrics)[1]);
  }

  /** The id of the sample GLB whose first part has this name. */
  async sample(name) {
    const { meshes } = await this.json('/v1/meshes');
    return meshes.find((mesh) => mesh.format === 'glb' && mesh.parts[0].name === name).id;
  }

  /** The field of a query of `/distance`, as float64. */
  async field(mesh, query) {
    const reply = await fetch(new URL(`/v1/meshes/${mesh}/distance?${query}&format=f64`, this.url));
    return new Float64Array(await reply.arrayBuffer());
  }
}

/** A service for one test, with whose end it ends, however that comes. */
export async function started(t, ...flags) {
  const service = await new Service(...flags).start();
  t.after(() => service.end());
  return service;
}
