// A sonar image on two canvases: cells by a look-up table (pixel -> cell), and over them axes, circles and pointer.
import { ink, prepare, watch, withPicture } from "ods-charts";
import { joinLink, leaveLink, request } from "ods-charts/frames.js";
import { withKeys } from "ods-charts/keys.js";
import { drawBox, drawLabels } from "ods-charts/labels.js";
import { drawScale, niceStep, pack, paletteOf } from "ods-charts/palettes.js";
import { drawRuler, measures, withRuler } from "ods-charts/ruler.js";

const KINDS = {
  detection: { colour: "#ff5a36", label: "detection" },
  right: { colour: "#4fd1a5", label: "right", sign: "✓" },
  false: { colour: "#ff5a36", label: "false", sign: "✕" },
  missed: { colour: "#ffffff", label: "missed", sign: "?", dash: [4, 3] },
  only_a: { colour: "#ff9d2e", label: "only A", sign: "A", dash: [9, 4] },
  only_b: { colour: "#37b6ff", label: "only B", sign: "B", dash: [2, 3], corners: 4 },
  truth: { colour: "#ffffff", label: "true object", dash: [4, 3] },
  track: { colour: "#ff6ad5", label: "track" },
};
const DIM = 0.35; // of what attention skips
const MARGIN = { left: 14, right: 74, top: 26, bottom: 24 };
const TURN_GAIN = 1.5; // a narrow fan lies on its side where it is larger by this at least
const RULER = 30; // of the button in the corner
const DEG = 180 / Math.PI;

const views = new Set();
let pointed = null; // {range_m, bearing_rad}: the pointer, in all views
let measured = null; // two of these: what the ruler lies between, in all views

function point(place) {
  pointed = place;
  for (const view of views) view.drawOver();
}

function measure(places) {
  measured = places;
  for (const view of views) view.drawOver();
}

// ---- computations without a canvas ----

function angleStep(rough_deg) {
  return [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 45].find((step) => step >= rough_deg) || 90;
}

function bordersOf(bearing) {
  const last = bearing.length - 1;
  if (!last) return [bearing[0] - 0.01, bearing[0] + 0.01];
  const borders = [1.5 * bearing[0] - 0.5 * bearing[1]];
  for (let beam = 0; beam < last; beam++) borders.push(0.5 * (bearing[beam] + bearing[beam + 1]));
  borders.push(1.5 * bearing[last] - 0.5 * bearing[last - 1]);
  return borders;
}

function geometryOf(frame) {
  const borders = bordersOf(frame.bearing_rad);
  const cell_m = frame.dr_m * frame.pool;
  const near_m = Math.max(0, frame.range0_m - 0.5 * frame.dr_m);
  return {
    beams: frame.beams, cells: frame.cells, cell_m, borders, near_m,
    first_m: frame.range0_m - 0.5 * frame.dr_m, // where the first cell begins
    far_m: frame.range0_m + (frame.samples - 0.5) * frame.dr_m,
    left: borders[0], right: borders[frame.beams],
  };
}

function beamAt(borders, bearing) {
  let low = 0;
  let high = borders.length - 1;
  if (!(bearing >= borders[low] && bearing < borders[high])) return -1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (bearing >= borders[middle]) low = middle;
    else high = middle;
  }
  return low;
}

// Colours by cell value, dimmed ones 256 further on, and nothing at 512.
function coloursOf(palette, scale, shown) {
  const colour = paletteOf(palette);
  const table = new Uint32Array(513);
  for (let value = 0; value < 256; value++) {
    const level = scale[0] + ((scale[1] - scale[0]) * value) / 255;
    const rgb = colour((level - shown[0]) / (shown[1] - shown[0]));
    table[value] = pack(rgb);
    table[256 + value] = pack(rgb.map((part) => Math.round(part * DIM)));
  }
  return table; // 512: transparent
}

// Of a fan seen with its axis to the right instead of up; starboard is below then.
const turned = ({ x0, x1, y0, y1 }) => ({ x0: y0, x1: y1, y0: -x1, y1: -x0 });

// Pixels that a metre has where all of an extent is to be seen.
const fitOf = ({ x0, x1, y0, y1 }, box) => Math.min(box.width / (x1 - x0), box.height / (y1 - y0));

// Where places of the image are on the canvas: `box` is the part of the canvas that the image may fill.
class Projection {
  constructor(geometry, presentation, box, zoom) {
    Object.assign(this, { geometry, box });
    this.isFan = presentation === "fan";
    const { left, right, far_m, near_m } = geometry;
    let extent = { x0: left * DEG, x1: right * DEG, y0: near_m, y1: far_m };
    if (this.isFan) {
      const arc = Array.from({ length: 181 }, (_, index) => left + ((right - left) * index) / 180);
      const across = arc.map((bearing) => far_m * Math.sin(bearing));
      const ahead = arc.map((bearing) => far_m * Math.cos(bearing));
      extent = { x0: Math.min(0, ...across), x1: Math.max(0, ...across), y0: Math.min(0, ...ahead), y1: Math.max(0, ...ahead) };
    }
    if (this.isFan && fitOf(turned(extent), box) > TURN_GAIN * fitOf(extent, box)) {
      this.isTurned = true;
      extent = turned(extent);
    }
    this.scaleX = box.width / (extent.x1 - extent.x0);
    this.scaleY = box.height / (extent.y1 - extent.y0);
    if (this.isFan) this.scaleX = this.scaleY = 0.97 * fitOf(extent, box);
    this.scaleX *= zoom.factor;
    this.scaleY *= zoom.factor;
    this.x = 0.5 * (extent.x0 + extent.x1) + zoom.x / this.scaleX;
    this.y = 0.5 * (extent.y0 + extent.y1) + zoom.y / this.scaleY;
  }
  toCanvas(range_m, bearing) {
    const across = this.isFan ? range_m * Math.sin(bearing) : bearing * DEG;
    const ahead = this.isFan ? range_m * Math.cos(bearing) : range_m;
    const [x, y] = this.isTurned ? [ahead, -across] : [across, ahead];
    const { box } = this;
    return [box.x + 0.5 * box.width + (x - this.x) * this.scaleX, box.y + 0.5 * box.height - (y - this.y) * this.scaleY];
  }
  toPlace(canvasX, canvasY) {
    const { box } = this;
    const x = this.x + (canvasX - box.x - 0.5 * box.width) / this.scaleX;
    const y = this.y - (canvasY - box.y - 0.5 * box.height) / this.scaleY;
    if (!this.isFan) return [y, x / DEG];
    return [Math.hypot(x, y), this.isTurned ? Math.atan2(-y, x) : Math.atan2(x, y)];
  }
  // Cell under each pixel of the box; `beams * cells` where there is none.
  table() {
    const { beams, cells, borders, first_m, cell_m } = this.geometry;
    const { width, height } = this.box;
    const table = new Int32Array(width * height);
    for (let row = 0, at = 0; row < height; row++) {
      for (let column = 0; column < width; column++, at++) {
        const [range_m, bearing] = this.toPlace(this.box.x + column + 0.5, this.box.y + row + 0.5);
        const cell = Math.floor((range_m - first_m) / cell_m);
        const beam = cell >= 0 && cell < cells ? beamAt(borders, bearing) : -1;
        table[at] = beam < 0 ? beams * cells : beam * cells + cell;
      }
    }
    return table;
  }
  // Near the apex of a fan beams are finer than pixels: [cell, pixel, ...] of all cells there, so that none is lost.
  crowded() {
    const { beams, cells, borders, first_m, cell_m } = this.geometry;
    const { width, height } = this.box;
    const finest = Math.min(...borders.slice(1).map((border, beam) => border - borders[beam]));
    const pixel = this.isFan ? 1 / this.scaleX : 0;
    const until = this.isFan ? Math.min(cells, Math.ceil((pixel / finest - first_m) / cell_m)) : 0;
    const pairs = [];
    const wide = !this.isFan && (finest * DEG * this.scaleX < 1); // more beams than columns
    for (let beam = 0; beam < beams; beam++) {
      for (let cell = 0; cell < (wide ? cells : until); cell++) {
        const middle = 0.5 * (borders[beam] + borders[beam + 1]);
        const [x, y] = this.toCanvas(first_m + (cell + 0.5) * cell_m, middle);
        const column = Math.floor(x - this.box.x);
        const row = Math.floor(y - this.box.y);
        if (column >= 0 && column < width && row >= 0 && row < height) pairs.push(beam * cells + cell, row * width + column);
      }
    }
    return Int32Array.from(pairs);
  }
}

// ---- the component ----

export default {
  template: `
    <div style="position: relative; width: 100%; height: 100%; min-height: 160px; overflow: hidden; cursor: crosshair">
      <canvas ref="image" style="position: absolute; image-rendering: pixelated"></canvas>
      <canvas ref="over" style="position: absolute; left: 0; top: 0; width: 100%; height: 100%"></canvas>
    </div>`,
  props: {
    channel: String, title: String, presentation: String, palette: String, attention: Boolean, pinned: Number,
    limits: Array, busy: String, draws: String,
  },
  created() {
    this.frame = null;
    this.isNew = false;
    this.zoom = { factor: 1, x: 0, y: 0 };
    this.drawn = { frames: 0, ms: 0 }; // for benchmarks and tests
  },
  mounted() {
    views.add(this);
    joinLink(this);
    this.$el.fanView = this;
    this.unwatch = watch(this.$el, () => this.redraw());
    this.unruled = withRuler(this.$el, () => measure(null));
    withPicture(this.$el, () => `${this.title} ${this.frame?.caption ?? ""}`);
    const over = this.$refs.over;
    withKeys(this.$el, over, "sonar image");
    over.addEventListener("pointermove", (event) => this.moved(event));
    over.addEventListener("pointerdown", (event) => this.pressed(event));
    over.addEventListener("pointerup", (event) => this.released(event));
    over.addEventListener("pointerleave", () => point(null));
    over.addEventListener("wheel", (event) => this.zoomed(event), { passive: false });
    over.addEventListener("dblclick", () => {
      clearTimeout(this.picking);
      this.setZoom({ factor: 1, x: 0, y: 0 });
    });
  },
  beforeUnmount() {
    views.delete(this);
    leaveLink(this);
    this.unwatch();
    this.unruled();
  },
  watch: {
    channel() {
      this.frame = null;
      request();
    },
    presentation() {
      this.setZoom({ factor: 1, x: 0, y: 0 });
    },
    palette() {
      this.redraw();
    },
    attention() {
      this.redraw();
    },
    limits() {
      this.redraw();
    },
    pinned() {
      this.drawOver();
    },
    title() {
      this.drawOver();
    },
    busy() {
      this.$refs.image.style.opacity = this.busy ? 0.45 : 1;
      this.drawOver();
    },
  },
  methods: {
    // -- what the link asks and tells --
    isShown() {
      return this.$el.clientWidth > 0 && this.$el.clientHeight > 0;
    },
    have() {
      if (!this.frame) return 0;
      const isCoarse = Math.ceil(this.frame.samples / this.wantedCells()) < this.frame.pool;
      return isCoarse ? 0 : this.frame.version;
    },
    // A cell is a pixel long at least, so that every cell is drawn.
    wantedCells() {
      const { height, width } = this.box();
      const longest = this.presentation === "fan" ? Math.max(Math.min(height, 1.2 * width), this.turnedLength()) : height;
      return Math.max(64, Math.min(4096, Math.floor(longest * this.zoom.factor)));
    },
    turnedLength() {
      return this.projected?.projection.isTurned ? this.box().width : 0;
    },
    show(frame) {
      const { bearing_rad, range0_m, dr_m, pool, beams, cells, samples } = frame;
      frame.shape = JSON.stringify([bearing_rad, range0_m, dr_m, pool, beams, cells, samples]);
      frame.geometry = frame.shape === this.frame?.shape ? this.frame.geometry : geometryOf(frame);
      this.frame = frame;
      this.isNew = true;
    },
    drawIfNew() {
      if (!this.isNew || !this.isShown()) return;
      this.isNew = false;
      const begin = performance.now();
      this.drawImage();
      this.drawOver();
      this.drawn.frames += 1;
      this.drawn.ms += performance.now() - begin;
    },
    redraw() {
      if (!this.$el || !this.isShown()) return;
      this.isNew = this.frame !== null;
      this.drawIfNew();
      this.drawOver();
      request();
    },
    // -- geometry --
    box() {
      const { clientWidth, clientHeight } = this.$el;
      return {
        x: MARGIN.left, y: MARGIN.top,
        width: Math.max(16, clientWidth - MARGIN.left - MARGIN.right),
        height: Math.max(16, clientHeight - MARGIN.top - MARGIN.bottom),
      };
    },
    // Tables are made again only when what they depend on has changed.
    project() {
      const { geometry } = this.frame;
      const box = this.box();
      const key = JSON.stringify([box, this.zoom, this.presentation]);
      if (this.projected?.key !== key || this.projected.geometry !== geometry) {
        const projection = new Projection(geometry, this.presentation, box, this.zoom);
        this.projected = { key, geometry, projection, table: projection.table(), crowded: projection.crowded() };
      }
      return this.projected;
    },
    shownLimits() {
      return this.limits || this.frame.scale_db;
    },
    // -- drawing --
    drawImage() {
      const { projection, table, crowded } = this.project();
      const { box } = projection;
      const canvas = this.$refs.image;
      if (canvas.width !== box.width || canvas.height !== box.height || !this.pixels) {
        Object.assign(canvas, { width: box.width, height: box.height });
        Object.assign(canvas.style, { left: `${box.x}px`, top: `${box.y}px` });
        this.context = canvas.getContext("2d");
        this.pixels = this.context.createImageData(box.width, box.height);
      }
      const out = new Uint32Array(this.pixels.data.buffer);
      const colours = coloursOf(this.palette, this.frame.scale_db, this.shownLimits());
      const cells = this.cellsToDraw();
      if (crowded.length) {
        const values = new Uint16Array(table.length);
        for (let pixel = 0; pixel < table.length; pixel++) values[pixel] = cells[table[pixel]];
        for (let pair = 0; pair < crowded.length; pair += 2) {
          const value = cells[crowded[pair]];
          const pixel = crowded[pair + 1];
          if (values[pixel] === 512 || (value & 255) > (values[pixel] & 255)) values[pixel] = value;
        }
        for (let pixel = 0; pixel < table.length; pixel++) out[pixel] = colours[values[pixel]];
      } else {
        for (let pixel = 0; pixel < table.length; pixel++) out[pixel] = colours[cells[table[pixel]]];
      }
      this.context.putImageData(this.pixels, 0, 0);
    },
    cellsToDraw() {
      const { data, attended } = this.frame;
      const cells = new Uint16Array(data.length + 1);
      cells.set(data);
      cells[data.length] = 512;
      if (this.attention && attended) for (let cell = 0; cell < data.length; cell++) if (!attended[cell]) cells[cell] += 256;
      return cells;
    },
    drawOver() {
      const canvas = this.$refs.over;
      if (!canvas || !this.isShown()) return;
      const { context, width: clientWidth, height: clientHeight } = prepare(canvas);
      const colour = ink();
      this.write(context, this.heading(), MARGIN.left, 17, colour, clientWidth - MARGIN.left - RULER);
      if (!this.frame) return this.write(context, this.busy || "no image yet", MARGIN.left, 60, colour, clientWidth);
      const { projection } = this.project();
      const { box } = projection;
      context.save();
      context.beginPath();
      context.rect(box.x, box.y, box.width, box.height);
      context.clip();
      const labels = this.drawGrid(context, projection);
      for (const circle of this.frame.circles) this.drawCircle(context, projection, circle);
      drawLabels(context, projection, this.frame);
      if (this.drag?.box) drawBox(context, projection, this.frame, [...this.drag.box.beams, ...this.drag.box.samples, this.draws]);
      this.drawPinned(context, projection);
      if (pointed) this.drawPointer(context, projection);
      for (const [text, x, y] of labels) this.label(context, text, x, y);
      if (measured) this.drawMeasured(context, projection);
      context.restore();
      this.drawScale(context, box);
      this.write(context, this.readout(), MARGIN.left, clientHeight - 8, colour, clientWidth - MARGIN.left - 4);
    },
    heading() {
      return [this.title, this.frame?.caption, this.frame && this.busy].filter(Boolean).join("  ·  ");
    },
    write(context, text, x, y, colour, most) {
      context.fillStyle = colour;
      context.textAlign = "left";
      context.fillText(text, x, y, most);
    },
    label(context, text, x, y) {
      context.textAlign = "left";
      const { box } = this.projected.projection;
      const width = context.measureText(text).width;
      const left = Math.min(Math.max(x + 3, box.x + 2), box.x + box.width - width - 3);
      const base = Math.min(Math.max(y - 3, box.y + 12), box.y + box.height - 4);
      context.lineWidth = 3;
      context.strokeStyle = "rgba(0, 0, 0, 0.7)";
      context.strokeText(text, left, base);
      context.fillStyle = "#ffffff";
      context.fillText(text, left, base);
    },
    // Range arcs and bearing lines; returns their labels, each where its line leaves what is seen.
    drawGrid(context, projection) {
      const { left, right, near_m, far_m } = projection.geometry;
      const labels = [];
      context.strokeStyle = "rgba(160, 170, 180, 0.45)";
      context.lineWidth = 1;
      const step_m = niceStep(far_m / 6 / this.zoom.factor);
      const bearings = Array.from({ length: 91 }, (_, index) => left + ((right - left) * index) / 90);
      const digits = Math.max(0, -Math.floor(Math.log10(step_m)));
      for (let range_m = Math.ceil(near_m / step_m) * step_m; range_m < far_m; range_m += step_m) {
        if (range_m < step_m / 2) continue;
        const end = this.line(context, projection, bearings.map((bearing) => [range_m, bearing]));
        if (end) labels.push([`${range_m.toFixed(digits)} m`, ...end]);
      }
      const step_deg = angleStep(((right - left) * DEG) / 7 / this.zoom.factor);
      const ranges = Array.from({ length: 41 }, (_, index) => near_m + ((far_m - near_m) * index) / 40);
      for (let deg = Math.ceil((left * DEG) / step_deg) * step_deg; deg <= right * DEG + 1e-9; deg += step_deg) {
        const end = this.line(context, projection, ranges.map((range_m) => [range_m, deg / DEG]));
        if (end) labels.push([`${Number(deg.toFixed(1)) + 0}°`, ...end]);
      }
      return labels;
    },
    line(context, projection, places) {
      const { box } = projection;
      let end = null;
      context.beginPath();
      for (const [range_m, bearing] of places) {
        const [x, y] = projection.toCanvas(range_m, bearing);
        context.lineTo(x, y);
        if (x >= box.x && x <= box.x + box.width && y >= box.y && y <= box.y + box.height) end = [x, y];
      }
      context.stroke();
      return end;
    },
    drawCircle(context, projection, [range_m, bearing_rad, radius_m, kind]) {
      const { colour, dash, sign, corners = 36 } = KINDS[kind] || KINDS.detection;
      const [ahead, across] = [range_m * Math.cos(bearing_rad), range_m * Math.sin(bearing_rad)];
      context.beginPath();
      for (let index = 0; index <= corners; index++) {
        const angle = (index / corners) * 2 * Math.PI;
        const [x, y] = [across + radius_m * Math.cos(angle), ahead + radius_m * Math.sin(angle)];
        context.lineTo(...projection.toCanvas(Math.hypot(x, y), Math.atan2(x, y)));
      }
      context.setLineDash([]);
      context.lineWidth = 3.5;
      context.strokeStyle = "rgba(0, 0, 0, 0.75)";
      context.stroke();
      context.setLineDash(dash || []);
      context.lineWidth = 1.7;
      context.strokeStyle = colour;
      context.stroke();
      context.setLineDash([]);
      if (sign) this.drawSign(context, projection, [range_m, bearing_rad, radius_m], sign, colour);
    },
    // Above the circle, as large at every scale: what is told by colour is told by shape, too.
    drawSign(context, projection, [range_m, bearing_rad, radius_m], sign, colour) {
      const [x, y] = projection.toCanvas(range_m, bearing_rad);
      const [, top] = projection.toCanvas(range_m + radius_m, bearing_rad);
      context.save();
      context.font = "bold 15px system-ui, sans-serif";
      context.textAlign = "center";
      context.lineWidth = 3.5;
      context.strokeStyle = "rgba(0, 0, 0, 0.8)";
      const above = y - Math.max(6, Math.abs(top - y)) - 4;
      context.strokeText(sign, x, above);
      context.fillStyle = colour;
      context.fillText(sign, x, above);
      context.restore();
    },
    drawPinned(context, projection) {
      const { near_m, far_m } = projection.geometry;
      if (!(this.pinned >= 0 && this.pinned < this.frame.beams)) return;
      const bearing = this.frame.bearing_rad[this.pinned];
      context.strokeStyle = "#ffffff";
      context.lineWidth = 1.2;
      context.setLineDash([6, 4]);
      this.line(context, projection, [[near_m, bearing], [0.5 * (near_m + far_m), bearing], [far_m, bearing]]);
      context.setLineDash([]);
    },
    drawPointer(context, projection) {
      const [x, y] = projection.toCanvas(pointed.range_m, pointed.bearing_rad);
      for (const [width, colour] of [[3, "rgba(0, 0, 0, 0.7)"], [1.2, "#ffffff"]]) {
        context.lineWidth = width;
        context.strokeStyle = colour;
        context.beginPath();
        for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
          context.moveTo(x + 4 * dx, y + 4 * dy);
          context.lineTo(x + 12 * dx, y + 12 * dy);
        }
        context.stroke();
      }
    },
    // A straight way on the bottom, which bends where beams are beside each other.
    drawMeasured(context, projection) {
      const [from, to] = measured.map(({ range_m, bearing_rad }) => [range_m * Math.cos(bearing_rad), range_m * Math.sin(bearing_rad)]);
      const points = Array.from({ length: 33 }, (_, index) => {
        const [ahead, across] = [0, 1].map((axis) => from[axis] + ((to[axis] - from[axis]) * index) / 32);
        return projection.toCanvas(Math.hypot(ahead, across), Math.atan2(across, ahead));
      });
      drawRuler(context, points, this.reading(), projection.box);
    },
    // What was measured, in words: in the sonar's plane.
    reading() {
      const [from, to] = measured;
      const turn = to.bearing_rad - from.bearing_rad;
      const apart = Math.sqrt(Math.max(0, from.range_m ** 2 + to.range_m ** 2 - 2 * from.range_m * to.range_m * Math.cos(turn)));
      const deg = (place) => `${(place.bearing_rad * DEG).toFixed(1)}°`;
      return [
        `${apart.toFixed(2)} m apart`,
        `range ${from.range_m.toFixed(2)} m to ${to.range_m.toFixed(2)} m, bearing ${deg(from)} to ${deg(to)}`,
      ];
    },
    drawScale(context, box) {
      const [low, high] = this.shownLimits();
      const heightOf = drawScale(context, box, [low, high], this.palette);
      for (const [, level] of this.frame.thresholds_db) {
        if (level < low || level > high) continue;
        context.fillStyle = KINDS.detection.colour;
        context.fillRect(box.x + box.width + 6, heightOf(level) - 1, 18, 2);
      }
    },
    readout() {
      if (!pointed) return this.legend();
      const spot = this.spotAt(pointed.range_m, pointed.bearing_rad);
      const place = `${pointed.range_m.toFixed(2)} m   ${(pointed.bearing_rad * DEG).toFixed(1)}°`;
      return spot ? `${place}   ${spot.level_db.toFixed(1)} dB   beam ${spot.beam}, sample ${spot.sample}` : place;
    },
    legend() {
      const counts = {};
      for (const [, , , kind] of this.frame.circles) counts[kind] = (counts[kind] || 0) + 1;
      const kinds = Object.entries(counts).map(([kind, count]) => `${KINDS[kind].sign || ""} ${count} ${KINDS[kind].label}${count > 1 && ["detection", "truth"].includes(kind) ? "s" : ""}`.trim());
      const levels = this.frame.thresholds_db.map(([name, level]) => `${name} ${level.toFixed(1)} dB`);
      return [...kinds, ...levels].join("   ");
    },
    // -- the pointer --
    spotAt(range_m, bearing_rad) {
      if (!this.frame) return null;
      const { geometry, data, scale_db, pool, samples } = this.frame;
      const cell = Math.floor((range_m - geometry.first_m) / geometry.cell_m);
      const beam = cell >= 0 && cell < geometry.cells ? beamAt(geometry.borders, bearing_rad) : -1;
      if (beam < 0) return null;
      const value = data[beam * geometry.cells + cell];
      const sample = Math.min(samples - 1, Math.floor((range_m - geometry.first_m) / (geometry.cell_m / pool)));
      return { range_m, bearing_rad, beam, sample, level_db: scale_db[0] + ((scale_db[1] - scale_db[0]) * value) / 255 };
    },
    // Beams and samples between two places of the canvas; what lies beside the image counts as its edge.
    between(from, to) {
      const spots = [from, to].map(({ x, y }) => this.nearest(this.rawPlace(x, y)));
      const ends = (name) => spots.map((spot) => spot[name]).sort((one, other) => one - other);
      return { beams: ends("beam"), samples: ends("sample") };
    },
    nearest({ range_m, bearing_rad }) {
      const { first_m, far_m, left, right } = this.frame.geometry;
      const inside = (value, low, high) => Math.min(Math.max(value, low + 1e-6), high - 1e-6);
      return this.spotAt(inside(range_m, first_m, far_m), inside(bearing_rad, left, right));
    },
    placeOf(event) {
      if (!this.frame) return null;
      const { range_m, bearing_rad } = this.rawPlace(event.offsetX, event.offsetY);
      return this.spotAt(range_m, bearing_rad);
    },
    rawPlace(x, y) {
      const [range_m, bearing_rad] = this.project().projection.toPlace(x, y);
      return { range_m, bearing_rad };
    },
    point(range_m, bearing_rad) {
      point({ range_m, bearing_rad });
    },
    moved(event) {
      if (this.drag) {
        this.drag.moved = this.drag.moved || Math.hypot(event.offsetX - this.drag.x, event.offsetY - this.drag.y) > 4;
        if (this.drag.moved && this.drag.ruled) {
          measure([this.rawPlace(this.drag.x, this.drag.y), this.rawPlace(event.offsetX, event.offsetY)]);
        } else if (this.drag.moved && this.drag.draws) {
          this.drag.box = this.between(this.drag, { x: event.offsetX, y: event.offsetY });
          return this.drawOver();
        } else if (this.drag.moved)
          return this.setZoom({
            factor: this.zoom.factor,
            x: this.drag.zoom.x - (event.offsetX - this.drag.x), y: this.drag.zoom.y + (event.offsetY - this.drag.y),
          });
      }
      const spot = this.placeOf(event);
      point(spot);
      if (spot) this.$emit("hover", spot);
    },
    pressed(event) {
      event.target.setPointerCapture(event.pointerId);
      const ruled = measures(event) && this.frame !== null;
      const draws = this.draws && event.button === 0 && !ruled && this.frame !== null;
      this.drag = { x: event.offsetX, y: event.offsetY, zoom: this.zoom, moved: false, ruled, draws };
      if (ruled) measure(null);
    },
    released(event) {
      const wasClick = this.drag && !this.drag.moved && !this.drag.ruled;
      const drawn = this.drag?.box;
      this.drag = null;
      if (drawn) return this.$emit("drawn", drawn);
      const spot = wasClick && event.button === 0 ? this.placeOf(event) : null;
      if (!spot) return;
      if (this.zoom.factor === 1) return this.$emit("pick", spot);
      clearTimeout(this.picking); // zoomed in, a second click may follow, which shows the whole image
      this.picking = setTimeout(() => this.$emit("pick", spot), 300);
    },
    zoomed(event) {
      event.preventDefault();
      if (!this.frame) return;
      const factor = Math.min(64, Math.max(1, this.zoom.factor * 1.25 ** (event.deltaY < 0 ? 1 : -1)));
      const change = factor / this.zoom.factor;
      const box = this.box();
      const x = event.offsetX - box.x - 0.5 * box.width;
      const y = 0.5 * box.height - (event.offsetY - box.y);
      this.setZoom(
        factor === 1 ? { factor, x: 0, y: 0 } : { factor, x: (this.zoom.x + x) * change - x, y: (this.zoom.y + y) * change - y },
      );
    },
    setZoom(zoom) {
      this.zoom = zoom;
      if (this.zooming) return;
      this.zooming = true;
      requestAnimationFrame(() => {
        this.zooming = false;
        this.redraw();
      });
    },
  },
};
