// What is wider than the page scrolls by itself; by keys too, once it can be reached.
function reachWide(selector, attributes) {
  for (const box of document.querySelectorAll(selector)) {
    const wide = box.scrollWidth > box.clientWidth;
    for (const [name, value] of Object.entries(attributes)) {
      if (wide) box.setAttribute(name, value);
      else box.removeAttribute(name);
    }
  }
}
function reachAllWide() {
  reachWide('.md-typeset__scrollwrap', {tabindex: '0', role: 'region', 'aria-label': 'A wide table'});
  reachWide('.md-typeset pre > code', {tabindex: '0'});
}
addEventListener('load', reachAllWide);
addEventListener('resize', reachAllWide);

// A session is copied without its prompts and without what the commands print.
document.addEventListener('click', (event) => {
  const button = event.target.closest?.('[data-clipboard-target]');
  const code = button && document.querySelector(button.dataset.clipboardTarget);
  if (!code?.querySelector('.gp')) return;
  const copy = code.cloneNode(true);
  for (const part of copy.querySelectorAll('.gp, .go')) part.remove();
  button.dataset.clipboardText = copy.textContent.replace(/\n{2,}/g, '\n').trim() + '\n';
}, true);
