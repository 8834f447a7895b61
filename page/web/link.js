// The flight in the address: a link holds all that decides how it goes.
const MARK = "#fly=";

export const hasState = () => location.hash.startsWith(MARK);

// The state of the address; null where it holds none or nonsense.
export function readState() {
  if (!hasState()) return null;
  try {
    const packed = location.hash.slice(MARK.length).replace(/-/g, "+").replace(/_/g, "/");
    const bytes = Uint8Array.from(atob(packed), (byte) => byte.charCodeAt(0));
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    return null;
  }
}

export function writeState(state) {
  const bytes = new TextEncoder().encode(JSON.stringify(state));
  const packed = btoa(String.fromCharCode(...bytes))
    .replace(/\+/g, "-")
    .replace(/\//g, "_")
    .replace(/=+$/, "");
  history.replaceState(null, "", `${MARK}${packed}`);
}
