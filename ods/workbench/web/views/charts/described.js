// A chart as the page describes it (ods/workbench/web/views/chart_view.py): its numbers read, and what of them is where.

// Numbers come as the base64 of float32, or {x0, dx} for even steps.
function numbers(given, count) {
  if (typeof given !== "string") return Float32Array.from({ length: count }, (_, place) => given.x0 + place * given.dx);
  const letters = atob(given);
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  return new Float32Array(bytes.buffer);
}

export function described(text) {
  const { x = null, panels = [], strips = [], columns = 1 } = JSON.parse(text);
  for (const panel of panels) {
    for (const curve of panel.curves) {
      curve.y = numbers(curve.y);
      curve.x = numbers(curve.x, curve.y.length);
    }
    for (const band of panel.bands) for (const column of ["x", "low", "high"]) band[column] = numbers(band[column]);
  }
  return { x, panels, strips, columns };
}

// The place of the value that is nearest to x; xs rise.
function nearest(xs, x) {
  let [low, high] = [0, xs.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] <= x) low = middle;
    else high = middle;
  }
  return high > low && xs[high] - x < x - xs[low] ? high : low;
}

// Names and values of a panel's curves at x: [[curve, value], ...]; of named points none.
export function valuesAt(panel, x) {
  const plain = panel.curves.filter((curve) => curve.label && curve.x.length && !curve.names.length);
  const within = (curve) => x >= curve.x[0] - 1e-9 && x <= curve.x[curve.x.length - 1] + 1e-9;
  const found = plain.filter(within).map((curve) => [curve, curve.y[nearest(curve.x, x)]]);
  return found.filter(([, value]) => !Number.isNaN(value));
}

// From and to of all x.
export function wholeOf({ x, panels }) {
  if (x.low !== null) return [x.low, x.high];
  const ends = panels.flatMap(({ curves }) => curves.flatMap((curve) => [...curve.x]));
  const [low, high] = [Math.min(...ends), Math.max(...ends)];
  if (!ends.length) return [0, 1];
  if (x.log) return [0.6 * low, 2 * high];
  return low < high ? [low, high] : [low - 0.5, high + 0.5];
}

// Lowest and highest of a panel between two x: what its axis says, or what there is. A band may run away: it is shown up
// to twice the height of the curves.
export function limitsOf(panel, [from, to]) {
  const { low: least, high: most, span } = panel.y;
  if (least !== null && most !== null) return [least, most];
  let [low, high] = [Infinity, -Infinity];
  const take = (xs, values) => {
    for (let k = 0; k < xs.length; k++) {
      if (Number.isNaN(values[k]) || xs[k] < from || xs[k] > to) continue;
      low = Math.min(low, values[k]);
      high = Math.max(high, values[k]);
    }
  };
  for (const curve of panel.curves) take(curve.x, curve.y);
  const [inner, outer] = [low, high];
  for (const band of panel.bands) for (const edge of [band.low, band.high]) take(band.x, edge);
  if (low > high) return [least ?? 0, most ?? (least ?? 0) + 1];
  const room = Math.max(outer - inner, span);
  [low, high] = [Math.max(low, inner - room), Math.min(high, outer + room)];
  const more = Math.max(0.06 * (high - low), 0.5 * (span - (high - low))) || 0.5;
  return [least ?? low - more, most ?? high + more];
}

// All numbers as CSV: a line for each x of any curve, a column for each curve, empty where a curve has none.
export function csvOf({ x, panels, strips }) {
  const columns = [];
  for (const { title, y, curves, bands } of panels) {
    const named = (label) => [title || y.label, label].filter(Boolean).join(": ");
    for (const curve of curves) {
      if (!curve.names.length) columns.push([named(curve.label), curve.x, (k) => short(curve.y[k])]);
      else columns.push([named(curve.label), curve.x, (k) => `${curve.names[k]}: ${short(curve.y[k])}`]);
    }
    for (const band of bands)
      for (const edge of ["low", "high"]) columns.push([named(`${band.label}, ${edge}`), band.x, (k) => short(band[edge][k])]);
  }
  for (const { label, spans } of strips) columns.push([`state of ${label}`, spans.map(([, from]) => from), (k) => spans[k][0]]);
  const rows = new Map();
  columns.forEach(([, xs, text], column) => {
    for (let k = 0; k < xs.length; k++) {
      const at = short(xs[k]);
      if (!rows.has(at)) rows.set(at, Array(columns.length).fill(""));
      rows.get(at)[column] = text(k);
    }
  });
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const lines = [...rows].sort(([one], [other]) => one - other).map(([at, values]) => [at, ...values]);
  return [[x.label, ...columns.map(([name]) => name)], ...lines].map((line) => line.map(quoted).join(",") + "\n").join("");
}

const short = (value) => (Number.isNaN(value) ? "" : String(Number(value.toPrecision(7))));
