// Where the service is: two folders above this page, which a proxy may have put below a path of its
// own. A copy of the page that no service serves says another address in `data-server`.
const given = document.documentElement.dataset.server;

// Without a slash at the end: the paths of the contract begin with one.
export const server = (given ?? new URL('../..', location.href).href).replace(/\/$/, '');
export const contract = document.querySelector('link[rel=service-desc]').href;
