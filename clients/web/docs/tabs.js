// The same request in several languages, one shown at a time. The choice holds for all operations
// of the page. Arrow keys move between tabs, as the ARIA pattern asks.
import {code, make} from './text.js';
import {LANGUAGES} from './examples.js';

const all = [];
let chosen = LANGUAGES[0][0];

function choose(name) {
  chosen = name;
  for (const one of all) one.show();
}

// `element` is to be put on the page, `say` takes the request that it shows (see examples.js).
export function tabs(id) {
  const panels = LANGUAGES.map(([name, write]) => {
    const block = code('', name);
    Object.assign(block, {id: `${id}-in-${name}`});
    block.setAttribute('role', 'tabpanel');
    block.setAttribute('aria-labelledby', `${id}-tab-${name}`);
    const tab = make('button.tab', {type: 'button', role: 'tab', id: `${id}-tab-${name}`,
      'aria-controls': block.id, onclick: () => choose(name)}, name);
    return {name, write, block, tab, text: block.querySelector('pre')};
  });
  const show = () => {
    for (const {name, block, tab} of panels) {
      block.hidden = name !== chosen;
      tab.setAttribute('aria-selected', String(name === chosen));
      tab.tabIndex = name === chosen ? 0 : -1;
    }
  };
  const list = make('.tabs', {role: 'tablist', 'aria-label': 'Language of the example', onkeydown: (event) => {
    const step = {ArrowLeft: -1, ArrowRight: 1}[event.key];
    if (!step) return;
    const at = panels.findIndex(({name}) => name === chosen);
    const next = panels[(at + step + panels.length) % panels.length];
    choose(next.name);
    next.tab.focus();
    event.preventDefault();
  }}, panels.map(({tab}) => tab));
  all.push({show});
  show();
  return {
    element: make('.languages', {}, list, panels.map(({block}) => block)),
    say: (request) => { for (const {write, text} of panels) text.textContent = write(request); },
  };
}
