// Tables that are wider than the page scroll by themselves; by keys too, once they can be reached.
function reachWideTables() {
  for (const wrap of document.querySelectorAll('.md-typeset__scrollwrap')) {
    if (wrap.scrollWidth > wrap.clientWidth) {
      wrap.tabIndex = 0;
      wrap.setAttribute('role', 'region');
      wrap.setAttribute('aria-label', 'A wide table');
    } else {
      for (const name of ['tabindex', 'role', 'aria-label']) wrap.removeAttribute(name);
    }
  }
}
addEventListener('load', reachWideTables);
addEventListener('resize', reachWideTables);

// A session is copied without its prompts and without what the commands print.
document.addEventListener('click', (event) => {
  const button = event.target.closest?.('[data-clipboard-target]');
  const code = button && document.querySelector(button.dataset.clipboardTarget);
  if (!code?.querySelector('.gp')) return;
  const copy = code.cloneNode(true);
  for (const part of copy.querySelectorAll('.gp, .go')) part.remove();
  button.dataset.clipboardText = copy.textContent.replace(/\n{2,}/g, '\n').trim() + '\n';
}, true);
