const KEY = 'corbslam.token';

/** The token of this tab: from the address once, then from the session's storage. */
export function takeToken(): string | undefined {
  const values = new URLSearchParams(location.hash.slice(1));
  const given = values.get('token');
  if (given !== null) {
    keepToken(given);
    values.delete('token');
    history.replaceState(null, '', `#${values}`);
  }
  return sessionStorage.getItem(KEY) ?? undefined;
}

export function keepToken(token: string): void {
  if (token) sessionStorage.setItem(KEY, token);
  else sessionStorage.removeItem(KEY);
}
