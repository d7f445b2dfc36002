// A service and a browser for all the tests of one file; both end with its last test.
import { after } from 'node:test';
import { launch } from './browser.mjs';
import { Service } from './service.mjs';

export async function served() {
  const service = await new Service().start();
  after(() => service.end());
  const browser = await launch();
  after(() => browser.close());
  return { browser, service };
}
