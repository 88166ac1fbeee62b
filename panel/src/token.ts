// The token of this page: out of the address' fragment, which a browser sends to nobody, or typed in. It lives as
// long as the tab.
const KEY = "takt.token";

/** Takes a token out of "#token=..." and out of the address, so that it is neither seen nor bookmarked. */
export function takeTokenFromAddress(): void {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given === null) return;
  sessionStorage.setItem(KEY, given);
  history.replaceState(null, "", location.pathname);
}
export const token = (): string => sessionStorage.getItem(KEY) ?? "";
export const setToken = (value: string): void => sessionStorage.setItem(KEY, value);
