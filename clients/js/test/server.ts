/**
 * A geodesicd of a test's own, with a store in a temporary folder. `GEODESICD` names the
 * server, `SAMPLES` a folder of sample meshes.
 */
import { spawn, type ChildProcess } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

export class Server {
  private constructor(
    readonly url: string,
    readonly process: ChildProcess,
    private readonly folder: string,
  ) {}

  /** Starts a server; `port` 0 is any. */
  static async start(flags: readonly string[] = [], port = 0): Promise<Server> {
    const binary = process.env['GEODESICD'];
    if (!binary) throw new Error('GEODESICD names no server');
    const folder = mkdtempSync(join(tmpdir(), 'js_client_'));
    const all = ['--listen', `127.0.0.1:${port}`, '--store', join(folder, 'store')];
    const env = Object.fromEntries(
      Object.entries(process.env).filter(([name]) => !name.startsWith('GEODESICD_')),
    );
    const child = spawn(binary, [...all, '--log-level', 'warn', ...flags], {
      env,
      stdio: ['ignore', 'pipe', 'ignore'],
    });
    for await (const line of createInterface({ input: child.stdout })) {
      const url = /^listening on (http:\S+)/.exec(line)?.[1];
      if (url) {
        child.stdout.resume();
        return new Server(url, child, folder);
      }
    }
    throw new Error(`geodesicd ${flags.join(' ')} did not start`);
  }

  /** Starts to drain; a request that runs is waited for. */
  drain(): void {
    this.process.kill('SIGTERM');
  }

  async stop(): Promise<void> {
    const over = once(this.process, 'exit');
    if (this.process.exitCode === null && this.process.signalCode === null) {
      this.process.kill('SIGKILL');
      await over;
    }
    rmSync(this.folder, { recursive: true, force: true });
  }
}

/** A sample mesh's bytes. */
export function sample(name: string): Uint8Array<ArrayBuffer> {
  const folder = process.env['SAMPLES'];
  if (!folder) throw new Error('SAMPLES names no folder');
  return new Uint8Array(readFileSync(join(folder, name)));
}
