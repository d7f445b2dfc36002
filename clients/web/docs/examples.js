// One request said three ways: by curl, by the Python client and by the JavaScript client. Each is
// made of the same parts, so that they cannot differ.
import {server} from './place.js';

const quoted = (text) => `'${String(text).replace(/'/g, `'\\''`)}'`;
const literal = (text) => JSON.stringify(String(text));
const isJson = (type) => /^application\/([\w.-]+\+)?json$/.test(type ?? '');  // and no list of lines of JSON

// A request: {method, target, headers, body, returns, needsToken}. `target` begins at the server's root;
// `body` is {json} or {file}, or nothing; `returns` is the media type of a good reply, or nothing.

export function asCurl({method, target, headers, body, needsToken}) {
  const parts = ['curl -s'];
  if (method === 'HEAD') parts.push('-I');
  else if (method !== 'GET' && !(method === 'POST' && body)) parts.push(`-X ${method}`);
  if (needsToken) parts.push('-H "Authorization: Bearer $TOKEN"');
  for (const [name, value] of Object.entries(headers)) parts.push(`-H ${quoted(`${name}: ${value}`)}`);
  if (body?.json !== undefined) parts.push(`-d ${quoted(body.json.replace(/\s*\n\s*/g, ' '))}`);
  if (body?.file) parts.push(`--data-binary @${/^[\w.-]+$/.test(body.file) ? body.file : quoted(body.file)}`);
  parts.push(quoted(server + target));
  return parts.join(' ');
}

export function asPython({method, target, headers, body, returns, needsToken}) {
  const lines = ['import geodesicd'];
  if (needsToken) lines.unshift('import os');
  if (body?.file) lines.unshift('from pathlib import Path');
  lines.push('');
  const token = needsToken ? ', token=os.environ["TOKEN"]' : '';
  lines.push(`client = geodesicd.Client(${literal(server)}${token})`);
  const call = [literal(method), literal(target)];
  // The client would ask for JSON.
  const all = isJson(returns) ? headers : {Accept: '*/*', ...headers};
  if (Object.keys(all).length) {
    const pairs = Object.entries(all).map(([name, value]) => `${literal(name)}: ${literal(value)}`);
    call.push(`headers={${pairs.join(', ')}}`);
  }
  if (body?.json !== undefined) call.push(`body=${literal(body.json.replace(/\s*\n\s*/g, ' '))}.encode()`);
  if (body?.file) call.push(`body=Path(${literal(body.file)}).read_bytes()`);
  lines.push(`reply = client.fetch(${call.join(', ')})`);
  lines.push(isJson(returns) ? 'print(reply.json())' : 'print(reply.status, len(reply.body))');
  return lines.join('\n');
}

export function asJavaScript({method, target, headers, body, returns, needsToken}) {
  const lines = ["import { GeodesicClient } from 'geodesicd-client';"];
  if (body?.file) lines.unshift("import { readFile } from 'node:fs/promises'; // in a page: a File");
  lines.push('');
  const token = needsToken ? ', { token: process.env.TOKEN }' : '';
  lines.push(`const client = new GeodesicClient(${literal(server)}${token});`);
  lines.push('const reply = await client.request({', `  method: ${literal(method)},`, `  path: ${literal(target)},`);
  if (Object.keys(headers).length) {
    const pairs = Object.entries(headers).map(([name, value]) => `${literal(name)}: ${literal(value)}`);
    lines.push(`  headers: { ${pairs.join(', ')} },`);
  }
  if (body?.json !== undefined) lines.push(`  body: ${literal(body.json.replace(/\s*\n\s*/g, ' '))},`);
  if (body?.file) lines.push(`  body: await readFile(${literal(body.file)}),`);
  lines.push('});');
  lines.push(isJson(returns) ? 'console.log(JSON.parse(new TextDecoder().decode(reply.body)));'
    : 'console.log(reply.status, reply.body.byteLength);');
  return lines.join('\n');
}

export const LANGUAGES = [['curl', asCurl], ['Python', asPython], ['JavaScript', asJavaScript]];
