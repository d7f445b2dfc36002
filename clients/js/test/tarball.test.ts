/** What `npm pack` makes, installed in a folder of its own and used from there. */
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import {
  cpSync,
  existsSync,
  mkdtempSync,
  readdirSync,
  readFileSync,
  realpathSync,
  rmSync,
  symlinkSync,
  writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { fixture } from './fixture.js';

const { server } = await fixture();
const run = promisify(execFile);
const root = fileURLToPath(new URL('..', import.meta.url));
const folder = mkdtempSync(join(tmpdir(), 'js_tarball_'));
const installed = join(folder, 'node_modules', 'geodesicd-client');

before(async () => {
  const pack = ['pack', '--ignore-scripts', '--json', '--pack-destination', folder]; // built already
  const { stdout } = await run('npm', pack, { cwd: root });
  const [{ filename }] = JSON.parse(stdout) as [{ filename: string }];
  writeFileSync(join(folder, 'package.json'), '{"private": true, "type": "module"}');
  await run('npm', ['install', '--no-audit', '--no-fund', '--offline', join(folder, filename)], {
    cwd: folder,
  });
});
after(() => rmSync(folder, { recursive: true, force: true }));

test('it has what it needs and no more', () => {
  assert.deepEqual(readdirSync(installed).sort(), ['LICENSE', 'README.md', 'dist', 'package.json']);
  assert.ok(!existsSync(join(folder, 'node_modules', 'three')), 'three came along');
  const files = readdirSync(join(installed, 'dist'), { recursive: true }) as string[];
  for (const name of ['index.js', 'index.d.ts', 'three.js', 'three.d.ts']) {
    assert.ok(files.includes(name), `${name} is missing`);
  }
  let seen = 0;
  for (const name of files.filter((one) => one.endsWith('.js'))) {
    const text = readFileSync(join(installed, 'dist', name), 'utf8');
    assert.doesNotMatch(text, /\bimport\(|\brequire\(/, name);
    const imports = /^(?:import|export)[^'";{]*(?:\{[^}'"]*\}\s*)?from\s*['"]([^'"]+)['"]/gm;
    for (const [, from] of text.matchAll(imports)) {
      const known = from!.startsWith('./') || (name === 'three.js' && from === 'three');
      seen += 1;
      assert.ok(known, `${name} needs ${from}, which a page has not`);
    }
  }
  assert.ok(seen > 30, 'hardly any import was found');
});

for (const moduleResolution of ['NodeNext', 'Bundler']) {
  test(`a stranger's program compiles, with ${moduleResolution}, and runs`, async () => {
    cpSync(join(root, 'test', 'consumer', 'consumer.ts'), join(folder, 'consumer.ts'));
    const module = moduleResolution === 'NodeNext' ? 'NodeNext' : 'ES2022';
    const options = {
      strict: true,
      noUncheckedIndexedAccess: true,
      exactOptionalPropertyTypes: true,
      skipLibCheck: false,
      target: 'ES2022',
      lib: ['ES2022', 'DOM', 'DOM.AsyncIterable'],
      module,
      moduleResolution,
      types: ['node'],
      typeRoots: [join(root, 'node_modules', '@types')],
    };
    writeFileSync(
      join(folder, 'tsconfig.json'),
      JSON.stringify({ compilerOptions: options, files: ['consumer.ts'] }),
    );
    const tsc = join(root, 'node_modules', 'typescript', 'bin', 'tsc');
    await run(process.execPath, [tsc, '-p', folder]).catch((error) => assert.fail(error.stdout));
    const samples = process.env['SAMPLES'] ?? '';
    const program = [join(folder, 'consumer.js'), server.url, join(samples, 'plane.glb')];
    const { stdout } = await run(process.execPath, program);
    assert.deepEqual(JSON.parse(stdout), {
      vertices: 10000,
      wide: 10000,
      length: 9,
      codes: ['bad_syntax', 'NetworkError'],
    });
  });
}

test('the helpers for three.js, once three is there', async () => {
  const script = "import { setField } from 'geodesicd-client/three'; console.log(typeof setField)";
  const use = () => run(process.execPath, ['--input-type=module', '-e', script], { cwd: folder });
  await assert.rejects(use(), /Cannot find package 'three'/);
  const three = realpathSync(join(root, 'node_modules', 'three'));
  symlinkSync(three, join(folder, 'node_modules', 'three'));
  assert.equal((await use()).stdout.trim(), 'function');
});
