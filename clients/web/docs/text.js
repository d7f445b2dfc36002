// Text to elements: a way to write elements, the part of Markdown that the document
// uses, and JSON in colours. Nothing is ever parsed as HTML.

import {server} from './place.js';

// make('a.muted', {href: '#x'}, 'text', element, [more])
export function make(kind, attributes, ...children) {
  const [tag, ...classes] = kind.split('.');
  const element = document.createElement(tag || 'div');
  if (classes.length) element.className = classes.join(' ');
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === false || value === null || value === undefined) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return element;
}

// `code`, **strong** and [text](address) within a line.
export function inline(text) {
  const parts = [];
  const pattern = /`([^`]+)`|\*\*([^*]+)\*\*|\[([^\]]+)\]\(((?:\/|#|https?:)[^)\s]*)\)/g;
  let end = 0;
  for (const match of text.matchAll(pattern)) {
    parts.push(text.slice(end, match.index));
    end = match.index + match[0].length;
    if (match[1] !== undefined) parts.push(make('code', {}, match[1]));
    else if (match[2] !== undefined) parts.push(make('strong', {}, ...inline(match[2])));
    else parts.push(make('a', {href: match[4].startsWith('/') ? server + match[4] : match[4]}, match[3]));
  }
  parts.push(text.slice(end));
  return parts.filter((part) => part !== '');
}

// A row's cells: what is between bars, but not between those in code.
function cells(line) {
  const row = line.trim().replace(/^\|/, '').replace(/\|$/, '');
  return (row.match(/(?:`[^`]*`|[^|`])+/g) ?? []).map((cell) => cell.trim());
}

function table(lines) {
  const [head, , ...rows] = lines.map(cells);
  return scroll(make('table', {},
    make('thead', {}, make('tr', {}, head.map((cell) => make('th', {}, inline(cell))))),
    make('tbody', {}, rows.map((row) => make('tr', {}, row.map((cell) => make('td', {}, inline(cell))))))));
}

// A table that scrolls by itself where it is wider than the page; by keys too, once it can be reached.
const reach = new ResizeObserver((entries) => {
  for (const box of new Set(entries.map(({target}) => target.closest('.scroll')))) {
    const wide = box.scrollWidth > box.clientWidth;
    for (const [name, value] of [['tabindex', '0'], ['role', 'region'], ['aria-label', 'A wide table']]) {
      if (wide) box.setAttribute(name, value);
      else box.removeAttribute(name);
    }
  }
});
export function scroll(content) {
  const box = make('.scroll', {}, content);
  for (const one of [box, content]) reach.observe(one);
  return box;
}

// Paragraphs, lists and tables, divided by empty lines.
export function markdown(text) {
  return (text ?? '').trim().split(/\n\s*\n/).filter(Boolean).map((block) => {
    const lines = block.split('\n');
    if (lines.length > 2 && lines.every((line) => line.trim().startsWith('|'))) return table(lines);
    if (/^\s*[-*] /.test(lines[0])) {
      const items = block.split(/^\s*[-*] /m).slice(1);
      return make('ul', {}, items.map((item) => make('li', {}, inline(item.trim()))));
    }
    return make('p', {}, inline(lines.map((line) => line.trim()).join(' ')));
  });
}

const kMostColoured = 60000;  // characters; beyond, elements for every number would take too long

// JSON, short arrays and objects on one line, in colours.
export function coloured(value) {
  const text = typeof value === 'string' ? value : pretty(value, '');
  if (text.length > kMostColoured) return [text];
  const parts = [];
  let end = 0;
  const pattern = /("(?:\\.|[^"\\])*")(\s*:)?|\b(true|false|null)\b|(-?\b\d[\d.eE+-]*)/g;
  for (const match of text.matchAll(pattern)) {
    parts.push(text.slice(end, match.index));
    end = match.index + match[0].length;
    const kind = match[2] ? 'key' : match[1] ? 'string' : match[3] ? 'word' : 'number';
    parts.push(make(`span.${kind}`, {}, match[1] ?? match[0]), match[2] ?? '');
  }
  parts.push(text.slice(end));
  return parts;
}

export function pretty(value, indent) {
  const flat = JSON.stringify(value);
  if (value === null || typeof value !== 'object' || flat.length + indent.length <= 64) {
    return flat.replace(/("(?:\\.|[^"\\])*")|([,:])/g, (all, text, mark) => text ?? `${mark} `);
  }
  const deeper = `${indent}  `;
  const inner = Array.isArray(value)
    ? value.map((item) => deeper + pretty(item, deeper))
    : Object.entries(value).map(([key, item]) => `${deeper}${JSON.stringify(key)}: ${pretty(item, deeper)}`);
  const [open, close] = Array.isArray(value) ? '[]' : '{}';
  return `${open}\n${inner.join(',\n')}\n${indent}${close}`;
}

// A block of code with a button that copies it.
export function code(content, label) {
  const block = make('pre', {tabindex: '0'}, content);
  const button = make('button.copy', {type: 'button', onclick: async () => {
    await navigator.clipboard.writeText(block.textContent);
    button.textContent = 'copied';
    setTimeout(() => { button.textContent = 'copy'; }, 1200);
  }}, 'copy');
  return make('.code', {}, make('.code-head', {}, make('span', {}, label ?? ''), button), block);
}
