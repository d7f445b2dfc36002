// Trying an operation: a form of its parameters, tabs that say the same by curl, Python and
// JavaScript, and what the server answers.
import {code, coloured, make, pretty} from './text.js';
import {exampleOf, resolve} from './schema.js';
import {server} from './place.js';
import {tabs} from './tabs.js';

const kMostShown = 20000;  // characters of a reply

const readable = (text) => encodeURIComponent(text).replace(/%3A/g, ':').replace(/%2C/g, ',');
const token = () => document.getElementById('token').value.trim();

// One parameter's field. Those that `begins` is false for begin empty: what is empty is not sent.
function field(parameter, begins, changed) {
  const schema = resolve(parameter.schema);
  const example = exampleOf(parameter);
  const many = schema.type === 'array';
  const shown = example === undefined ? '' : many ? [example].flat().join('\n') : String(example);
  const start = begins ? shown : '';
  let input;
  if (schema.enum) {
    input = make('select', {}, make('option', {value: ''}, ''),
      schema.enum.map((value) => make('option', {}, String(value))));
    input.value = start;
  } else if (many) {
    input = make('textarea', {rows: '2', placeholder: shown || 'one a line'});
    input.value = start;
  } else {
    input = make('input', {type: 'text', placeholder: shown, spellcheck: 'false'});
    input.value = start;
  }
  if (parameter.name === 'id' && parameter.in === 'path') input.setAttribute('list', 'mesh-ids');
  input.dataset.parameter = parameter.name;
  input.addEventListener('input', changed);
  const values = () => (many ? input.value.split('\n') : [input.value])
    .map((value) => value.trim()).filter((value) => value !== '');
  const label = make('label', {}, make('span', {}, make('code', {}, parameter.name),
    parameter.required ? make('span.required', {}, 'required') : null), input);
  return {parameter, label, values};
}

// The body's field: JSON to edit, or a file.
function bodyField(body, changed) {
  const types = Object.keys(body?.content ?? {});
  if (!types.length) return null;
  const json = types.find((type) => type.endsWith('json') && exampleOf(body.content[type]) !== undefined);
  const input = json ? make('textarea.json', {rows: '5', spellcheck: 'false'}) : make('input', {type: 'file'});
  if (json) input.value = pretty(exampleOf(body.content[json]), '');
  input.addEventListener('input', changed);
  return {
    label: make('label.wide', {}, make('span', {}, 'Body ', make('span.muted', {}, json ?? 'a file')), input),
    type: json,
    content: () => (json ? input.value : input.files[0]),
    said: () => (json ? {json: input.value} : {file: input.files[0]?.name ?? 'mesh.glb'}),
  };
}

// Numbers of a bare array, the first of them.
function numbers(buffer, dtype) {
  const kinds = {'<f4': Float32Array, '<f8': Float64Array, '<u2': Uint16Array, '<u4': Uint32Array};
  const Kind = kinds[dtype];
  if (!Kind || buffer.byteLength % Kind.BYTES_PER_ELEMENT) return '';
  const all = new Kind(buffer);
  return `\n\n${[...all.subarray(0, 12)].join(', ')}${all.length > 12 ? ', …' : ''}`;
}

async function show(reply, place, started) {
  const type = reply.headers.get('Content-Type') ?? '';
  const headers = make('details', {}, make('summary', {}, 'Headers'),
    make('pre', {}, [...reply.headers].map(([name, value]) => `${name}: ${value}`).join('\n')));
  const bytes = reply.status === 204 ? new ArrayBuffer(0) : await reply.arrayBuffer();
  const took = Math.round(performance.now() - started);
  const status = make(`p.status.${reply.ok ? 'good' : 'bad'}`, {},
    make('strong', {}, `${reply.status} ${reply.statusText}`),
    ` ${type || 'no body'} · ${bytes.byteLength.toLocaleString('en')} bytes · ${took} ms`);
  const parts = [status, headers];
  if (/json|text|yaml/.test(type) && bytes.byteLength) {
    let text = new TextDecoder().decode(bytes);
    try { text = pretty(JSON.parse(text), ''); } catch { /* shown as it came */ }
    const cut = text.length > kMostShown ? `\n… ${text.length - kMostShown} characters more` : '';
    parts.push(code([...coloured(text.slice(0, kMostShown)), cut], 'Reply'));
  } else if (bytes.byteLength) {
    const url = URL.createObjectURL(new Blob([bytes], {type}));
    if (type.startsWith('image/')) parts.push(make('img', {src: url, alt: 'The picture'}));
    const dtype = reply.headers.get('Geo-Dtype');
    if (dtype) parts.push(code(`${dtype} [${reply.headers.get('Geo-Shape')}]${numbers(bytes, dtype)}`, 'Reply'));
    parts.push(make('p', {}, make('a', {href: url, download: 'reply'}, 'Save the reply')));
  }
  place.replaceChildren(...parts);
}

// The media type that a good reply has unless another is asked for; nothing where it has no body.
function returnedType(responses) {
  const good = Object.entries(responses).find(([status]) => status.startsWith('2'))?.[1];
  return Object.keys(resolve(good)?.content ?? {})[0];
}

// The form and the tabs of an operation. The tabs follow the form.
export function tryIt({id, method, path, parameters, body, authorised, responses, 'x-one-of': choices = []}) {
  const shown = tabs(id);
  const answer = make('.answer', {'aria-live': 'polite'});
  const update = () => shown.say({
    method, target: target(), headers: headers(), body: content?.said(), returns: returnedType(responses),
    needsToken: authorised && token() !== '',
  });
  // Of parameters that exclude each other, the first stands for all.
  const begins = (parameter) => parameter.required || parameter.name === choices[0];
  const fields = parameters.map((parameter) => field(parameter, begins(parameter), update));
  const content = bodyField(body, update);

  const target = () => {
    let address = path;
    const query = [];
    for (const {parameter, values} of fields) {
      const all = values();
      if (parameter.in === 'path') address = address.replace(`{${parameter.name}}`, readable(all[0] ?? ''));
      if (parameter.in === 'query') query.push(...all.map((value) => `${readable(parameter.name)}=${readable(value)}`));
    }
    return address + (query.length ? `?${query.join('&')}` : '');
  };
  const headers = () => {
    const list = {};
    for (const {parameter, values} of fields) {
      if (parameter.in === 'header' && values().length) list[parameter.name] = values().join(', ');
    }
    if (content?.type) list['Content-Type'] = content.type;
    return list;
  };
  const send = async (event) => {
    event.preventDefault();
    const list = headers();
    if (token()) list.Authorization = `Bearer ${token()}`;
    answer.replaceChildren(make('p.muted', {}, 'asking…'));
    const started = performance.now();
    try {
      const reply = await fetch(server + target(), {method, headers: list, body: content?.content(), cache: 'no-store'});
      await show(reply, answer, started);
    } catch (error) {
      answer.replaceChildren(make('p.status.bad', {}, `No reply: ${error.message}`));
    }
  };
  const optional = fields.filter(({parameter}) => !begins(parameter));
  const form = make('details.try', {}, make('summary', {}, 'Try it'),
    make('form', {onsubmit: send},
      make('.fields', {}, fields.filter(({parameter}) => begins(parameter)).map(({label}) => label)),
      optional.length ? make('details', {}, make('summary', {}, `${optional.length} optional`),
        make('.fields', {}, optional.map(({label}) => label))) : null,
      content?.label, make('button.send', {type: 'submit'}, `Send ${method}`)),
    answer);
  document.getElementById('token').addEventListener('input', update);
  form.addEventListener('ids', update);
  update();
  return [shown.element, form];
}

// Offers the ids of the meshes that the server has, and takes the first of them; but
// not for a deletion, which one should mean.
export async function offerMeshes() {
  try {
    const headers = token() ? {Authorization: `Bearer ${token()}`} : {};
    const reply = await fetch(`${server}/v1/meshes?limit=100`, {headers});
    if (!reply.ok) return;
    const {meshes} = await reply.json();
    const list = document.getElementById('mesh-ids') ?? make('datalist', {id: 'mesh-ids'});
    list.replaceChildren(...meshes.map((mesh) => make('option', {value: mesh.id},
      `${mesh.parts.find((part) => part.name)?.name ?? mesh.format}, ${mesh.vertices} vertices`)));
    document.body.append(list);
    if (!meshes.length) return;
    for (const input of document.querySelectorAll('input[list=mesh-ids]')) {
      if (input.closest('section').dataset.operation.startsWith('DELETE')) continue;
      input.value = meshes[0].id;
      input.closest('details.try').dispatchEvent(new Event('ids'));
    }
  } catch { /* the document's own example stays */ }
}
