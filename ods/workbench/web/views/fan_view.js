// A sonar image on two canvases: cells by a look-up table (pixel -> cell), and over them axes, circles and pointer.
import { ink, prepare, watch, withPicture } from "ods-charts";
import { followCursors } from "ods-charts/cursors.js";
import { joinLink, leaveLink, request } from "ods-charts/frames.js";
import { withKeys } from "ods-charts/keys.js";
import { drawScale } from "ods-charts/palettes.js";
import { withRuler } from "ods-charts/ruler.js";
import { fill } from "ods-fan/cells.js";
import { drawBox, drawLabels } from "ods-fan/labels.js";
import { drawCircle, drawGrid, drawLabel, drawMeasured, drawPinned, drawPointer, KINDS, readingOf } from "ods-fan/marks.js";
import { pointing } from "ods-fan/pointing.js";
import { DEG, geometryOf, Projection } from "ods-fan/projection.js";

const MARGIN = { left: 14, right: 74, top: 26, bottom: 24 };
const RULER = 30; // of the button in the corner

const views = new Set();
let measured = null; // two {range_m, bearing_rad}: what the ruler lies between, in all views

function measure(places) {
  measured = places;
  for (const view of views) view.drawOver();
}

export default {
  mixins: [pointing(measure)],
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
    this.pointed = {}; // by the pointer in any view
    this.drawn = { frames: 0, ms: 0 }; // for benchmarks and tests
  },
  mounted() {
    views.add(this);
    joinLink(this);
    this.$el.fanView = this;
    this.unwatch = watch(this.$el, () => this.redraw());
    this.unruled = withRuler(this.$el, () => measure(null));
    withPicture(this.$el, () => `${this.title} ${this.frame?.caption ?? ""}`);
    withKeys(this.$el, this.$refs.over, "sonar image");
    this.unfollow = followCursors((pointed) => {
      this.pointed = pointed;
      this.drawOver();
    });
    for (const [name, listener] of Object.entries(this.listeners()))
      this.$refs.over.addEventListener(name, listener, { passive: name !== "wheel" });
  },
  beforeUnmount() {
    views.delete(this);
    leaveLink(this);
    this.unwatch();
    this.unruled();
    this.unfollow();
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
    // -- what the link asks and reports --
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
      const { palette, attention } = this;
      const out = new Uint32Array(this.pixels.data.buffer);
      fill(out, this.frame, { table, crowded }, { palette, attention, limits: this.shownLimits() });
      this.context.putImageData(this.pixels, 0, 0);
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
      const labels = drawGrid(context, projection, this.zoom.factor);
      for (const circle of this.frame.circles) drawCircle(context, projection, circle);
      drawLabels(context, projection, this.frame);
      if (this.drag?.box) drawBox(context, projection, this.frame, [...this.drag.box.beams, ...this.drag.box.samples, this.draws]);
      if (this.pinned >= 0 && this.pinned < this.frame.beams) drawPinned(context, projection, this.frame.bearing_rad[this.pinned]);
      drawPointer(context, projection, this.pointed);
      for (const [text, x, y] of labels) drawLabel(context, text, x, y, box);
      if (measured) drawMeasured(context, projection, measured);
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
    reading() {
      return readingOf(measured);
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
      const { range, bearing } = this.pointed;
      if (range === undefined || bearing === undefined) return this.legend();
      const spot = this.spotAt(range, bearing);
      const place = `${range.toFixed(2)} m   ${(bearing * DEG).toFixed(1)}°`;
      return spot ? `${place}   ${spot.level_db.toFixed(1)} dB   beam ${spot.beam}, sample ${spot.sample}` : place;
    },
    legend() {
      const counts = {};
      for (const [, , , kind] of this.frame.circles) counts[kind] = (counts[kind] || 0) + 1;
      const kinds = Object.entries(counts).map(([kind, count]) => `${KINDS[kind].sign || ""} ${count} ${KINDS[kind].label}${count > 1 && ["detection", "truth"].includes(kind) ? "s" : ""}`.trim());
      const levels = this.frame.thresholds_db.map(([name, level]) => `${name} ${level.toFixed(1)} dB`);
      return [...kinds, ...levels].join("   ");
    },
  },
};
