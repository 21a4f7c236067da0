// Where the pointer is on axes that views share ("range", "level", "time"): each view that has one shows the same place.

const followers = new Set();

// Calls back with {axis: value, ...} of what is pointed at in any view, {} when nothing is; returns what ends that.
export function followCursors(pointed) {
  followers.add(pointed);
  return () => followers.delete(pointed);
}

export function pointAt(places) {
  for (const pointed of followers) pointed(places);
}
