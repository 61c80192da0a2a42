const KEY = 'corbslam.token';
/** Where the browser keeps nothing for this page. */
let held: string | undefined;

/** The token of this tab: from the address once, then from the session's storage. */
export function takeToken(): string | undefined {
  const values = new URLSearchParams(location.hash.slice(1));
  const given = values.get('token');
  if (given !== null) {
    keepToken(given);
    values.delete('token');
    history.replaceState(null, '', `#${values}`);
  }
  try {
    return sessionStorage.getItem(KEY) ?? held;
  } catch {
    return held;
  }
}

export function keepToken(token: string): void {
  held = undefined;
  try {
    if (token) sessionStorage.setItem(KEY, token);
    else sessionStorage.removeItem(KEY);
  } catch {
    // A browser that forbids storage: the token lives as long as the page.
    held = token || undefined;
  }
}
