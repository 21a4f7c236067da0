// Where values of a chart are on its canvas, what is at a place of it, and what of its axes a wheel or a box shows.
import { valuesAt } from "./described.js";
import { styleOf } from "./index.js";
import { ROW } from "./options.js";

const NEAR = 7; // pixels from a line that still catch it
const STILL = 4; // a drag that is shorter is a click
const LEAST = 1e-4; // share of the whole that can be zoomed into

export class Places {
  // ends: of what is shown, x: and y: of each panel; whole: of all x.
  constructor(about, laid, ends, whole) {
    Object.assign(this, { about, laid, ends, whole });
    this.boxes = [...laid.panels, ...(laid.strips ? [laid.strips] : [])];
  }
  toX(box, value) {
    return box.x + shareOf(value, this.ends.x, this.about.x) * box.width;
  }
  toY(place, value) {
    const [box, { y }] = [this.laid.panels[place], this.about.panels[place]];
    const share = shareOf(value, this.ends.y[place], y);
    return box.y + (y.inverse ? share : 1 - share) * box.height;
  }
  xAt(box, x) {
    return valueAt((x - box.x) / box.width, this.ends.x, this.about.x);
  }
  yAt(place, at) {
    const [box, { y }] = [this.laid.panels[place], this.about.panels[place]];
    const share = (at - box.y) / box.height;
    return valueAt(y.inverse ? share : 1 - share, this.ends.y[place], y);
  }
  // What is at a place of the canvas: the panel's or the strips' box, and the panel's or the strip's place.
  under(x, y) {
    const { panels, strips } = this.laid;
    const within = (box) => x >= box.x - 4 && x <= box.x + box.width + 4 && y >= box.y - 4 && y <= box.y + box.height + 4;
    const place = panels.findIndex(within);
    const strip = strips && y >= strips.y && y < strips.y + strips.height ? Math.floor((y - strips.y) / ROW) : null;
    return { x, y, place, strip, box: place >= 0 ? panels[place] : strips && within(strips) ? strips : null };
  }
  // The value of a line's axis at a place of the canvas, within what is shown.
  valueOf(line, { box, place }, x, y) {
    const [low, high] = line.axis === "x" ? this.ends.x : this.ends.y[place];
    return Math.min(high, Math.max(low, line.axis === "x" ? this.xAt(box, x) : this.yAt(place, y)));
  }
  lineAt({ x, y, place, box }) {
    if (place < 0) return null;
    const apart = (line) => Math.abs(line.axis === "x" ? this.toX(box, line.value) - x : this.toY(place, line.value) - y);
    const near = this.about.panels[place].lines.filter((line) => line.draggable && apart(line) <= NEAR);
    return near.sort((one, other) => apart(one) - apart(other))[0] || null;
  }
  // The box between two places, [[left, right], [top, bottom]]: over the whole height where the axis fits what is shown.
  // null: it is too small.
  frame({ box, place, x, y }, to) {
    if (Math.abs(to.x - x) < STILL && Math.abs(to.y - y) < STILL) return null;
    const within = (value, from, size) => Math.min(from + size, Math.max(from, value));
    const sides = (one, other, from, size) => [one, other].map((each) => within(each, from, size)).sort((a, b) => a - b);
    const across = sides(x, to.x, box.x, box.width);
    return [across, this.fits(place) ? [box.y, box.y + box.height] : sides(y, to.y, box.y, box.height)];
  }
  fits(place) {
    return place < 0 || this.about.panels[place].y.low === null || this.about.panels[place].y.high === null;
  }
  // What of the axes is in a box: {x, y: of its panel or null}; null: nothing one could see.
  framed({ box, place }, [across, down]) {
    if (across[1] - across[0] < STILL || down[1] - down[0] < STILL) return null;
    const y = this.fits(place) ? null : down.map((each) => this.yAt(place, each)).sort((one, other) => one - other);
    return { x: across.map((each) => this.xAt(box, each)), y };
  }
  // What of the x is shown after a turn of the wheel over a place, or beside it; null: all.
  zoomed({ box, x }, turned, moves) {
    const [at, factor, by] = [(x - box.x) / box.width, Math.exp(0.0015 * turned), 0.001 * turned];
    const shares = moves ? [by, 1 + by] : [at - at * factor, at + (1 - at) * factor];
    const part = shares.map((share) => valueAt(share, this.ends.x, this.about.x));
    if (moves && (part[0] < this.whole[0] || part[1] > this.whole[1])) return this.ends.x;
    const [from, to] = [Math.max(this.whole[0], part[0]), Math.min(this.whole[1], part[1])];
    if (shareOf(to, this.whole, this.about.x) - shareOf(from, this.whole, this.about.x) < LEAST) return this.ends.x;
    return from > this.whole[0] || to < this.whole[1] ? [from, to] : null;
  }
  // What is read at a place: [[role or null, text], ...].
  reading(at) {
    const x = this.xAt(at.box, at.x);
    const rows = at.place >= 0 ? [...this.curvesAt(at, x), ...this.namesAt(at)] : this.statesAt(at, x);
    return [[null, `${this.about.x.label}: ${rounded(x, this.ends.x)}`], ...rows];
  }
  curvesAt({ place }, x) {
    const found = valuesAt(this.about.panels[place], x);
    const { y, title } = this.about.panels[place];
    return found.map(([{ role, label }, value]) => [role, `${label || title || y.label}: ${rounded(value, this.ends.y[place])}`]);
  }
  namesAt({ x, y, place, box }) {
    const isNear = (curve, k) => Math.hypot(this.toX(box, curve.x[k]) - x, this.toY(place, curve.y[k]) - y) <= 2 * NEAR;
    const said = (curve, k) => [curve.role, `${curve.names[k]}: ${[curve.x[k], curve.y[k]].map((each) => Number(each.toPrecision(3))).join(", ")}`];
    return this.about.panels[place].curves.flatMap((curve) => curve.names.flatMap((_, k) => (isNear(curve, k) ? [said(curve, k)] : [])));
  }
  statesAt({ strip }, x) {
    const { label, spans } = this.about.strips[strip ?? 0];
    const [role] = spans.find(([, from, to]) => x >= from && x <= to) || [];
    return role ? [[role, `${label}: ${styleOf(role).label}`]] : [];
  }
}

function shareOf(value, [low, high], { log }) {
  return log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
}

function valueAt(share, [low, high], { log }) {
  return log ? low * (high / low) ** share : low + share * (high - low);
}

// As exactly as a pixel shows.
function rounded(value, [low, high]) {
  const digits = Math.max(0, 3 - Math.ceil(Math.log10(Math.abs(high - low) || 1)));
  return value.toFixed(Math.min(6, digits));
}
