// An echogram on two canvases: levels of range against ping, the highest of what shares a pixel; over them axes, echoes,
// tracks and true objects, and above them strips that say where images and lists were not to be trusted.
import { gridInk, halo, ink, legend, legendOf, prepare, styleOf, ticks, watch, withPicture } from "ods-charts";
import { joinLink, leaveLink, request } from "ods-charts/frames.js";
import { withKeys } from "ods-charts/keys.js";
import { drawScale, pack, paletteOf } from "ods-charts/palettes.js";

const MARGIN = { left: 58, right: 74, top: 26, bottom: 62 };
const STRIP = 16; // of one that says of each ping whether it is of use
const STILL = 4; // pixels of movement that are still a click
const MOST_ZOOM = 64;
const ECHO = "#ff5a36";
const STRIPS = [
  { layer: "faults", name: "image", of: "faults", colours: ["#ff8c42", "#c24a00"] },
  { layer: "validity", name: "list", of: "invalid", colours: ["#ff6b6b", "#c1121f"] },
];

export default {
  template: `
    <div style="position: relative; width: 100%; height: 100%; min-height: 160px; overflow: hidden; cursor: crosshair">
      <canvas ref="image" style="position: absolute"></canvas>
      <canvas ref="over" style="position: absolute; inset: 0; width: 100%; height: 100%; touch-action: none"></canvas>
    </div>`,
  props: {
    channel: String, title: String, busy: String, layers: String, palette: String, limits: Array, shown: Array,
    cursor: Number, marked: Number,
  },
  created() {
    this.now = { ...this.$props }; // as the page has set them since
    this.take();
    this.frame = null;
    this.isNew = false;
    this.part = null; // {place: [from, to], range: [from, to]} that is seen; null: all
    this.pointer = this.pressed = null;
    this.drawn = { frames: 0 }; // for tests
  },
  mounted() {
    this.$el.echogramView = this;
    this.unwatch = watch(this.$el, () => this.redraw());
    withPicture(this.$el, () => this.now.title);
    withKeys(this.$el, this.$refs.over, "echogram");
    const listener = {
      pointermove: (event) => this.move(event),
      pointerdown: (event) => this.press(event),
      pointerup: (event) => this.release(event),
      pointerleave: () => this.leave(),
      wheel: (event) => this.zoom(event),
      dblclick: () => this.see(null),
    };
    for (const [name, call] of Object.entries(listener))
      this.$refs.over.addEventListener(name, call, { passive: name !== "wheel" });
    joinLink(this);
  },
  beforeUnmount() {
    leaveLink(this);
    this.unwatch();
  },
  methods: {
    // -- what the link asks and reports --
    isShown() {
      return this.$el.clientWidth > 0 && this.$el.clientHeight > 0;
    },
    have() {
      return this.frame ? this.frame.version : 0;
    },
    wantedCells() {
      return 4096; // all: what shares a pixel is found here
    },
    show(frame) {
      const far_m = frame.samples * frame.cell_m;
      if (this.frame && (this.frame.pings !== frame.pings || Math.abs(this.far_m - far_m) > 1e-6)) this.part = null;
      this.frame = frame;
      this.far_m = far_m;
      this.isNew = true;
    },
    drawIfNew() {
      if (!this.isNew || !this.isShown()) return;
      this.isNew = false;
      this.drawImage();
      this.drawOver();
      this.drawn.frames += 1;
    },
    redraw() {
      if (!this.$el || !this.isShown()) return;
      this.isNew = this.frame !== null;
      this.drawIfNew();
      this.drawOver();
      request();
    },
    take() {
      const none = { place: [], range_m: [] };
      this.over = { echoes: none, tracks: [], truths: [], faults: [], invalid: [], ...JSON.parse(this.now.layers) };
    },
    set(name, value) {
      this.now[name] = value;
      if (name === "layers") this.take();
      if (name === "palette" || name === "limits" || name === "shown") this.redraw();
      else this.drawOver();
    },
    has(layer) {
      return this.now.shown.includes(layer);
    },
    // -- geometry --
    strips() {
      return STRIPS.filter((strip) => this.has(strip.layer));
    },
    box() {
      const { clientWidth, clientHeight } = this.$el;
      const top = MARGIN.top + this.strips().length * STRIP + 8;
      return {
        x: MARGIN.left, y: top, width: Math.max(16, clientWidth - MARGIN.left - MARGIN.right),
        height: Math.max(16, clientHeight - top - MARGIN.bottom),
      };
    },
    seen() {
      return this.part || { place: [0, this.frame.pings], range: [0, this.far_m] };
    },
    toX(place) {
      const { x, width } = this.box();
      const [from, to] = this.seen().place;
      return x + ((place - from) / (to - from)) * width;
    },
    toY(range_m) {
      const { y, height } = this.box();
      const [from, to] = this.seen().range;
      return y + ((range_m - from) / (to - from)) * height;
    },
    spotAt(x, y) {
      if (!this.frame) return null;
      const box = this.box();
      if (x < box.x || x >= box.x + box.width || y < MARGIN.top || y >= box.y + box.height) return null;
      const { place, range } = this.seen();
      const at = place[0] + ((x - box.x) / box.width) * (place[1] - place[0]);
      const range_m = range[0] + ((y - box.y) / box.height) * (range[1] - range[0]);
      return { place: Math.min(this.frame.pings - 1, Math.floor(at)), at, range_m, isInside: y >= box.y };
    },
    // -- drawing --
    drawImage() {
      const box = this.box();
      const canvas = this.$refs.image;
      Object.assign(canvas, { width: Math.floor(box.width), height: Math.floor(box.height) });
      Object.assign(canvas.style, { left: `${box.x}px`, top: `${box.y}px` });
      const context = canvas.getContext("2d");
      const pixels = context.createImageData(canvas.width, canvas.height);
      this.fill(new Uint32Array(pixels.data.buffer), canvas.width, canvas.height);
      context.putImageData(pixels, 0, 0);
    },
    // Each pixel has the colour of the highest cell that it covers, in both directions.
    fill(out, width, height) {
      const { data, cells, beams: columns, per_column, cell_m, pool } = this.frame;
      const { place, range } = this.seen();
      const colours = this.colours();
      const edges = (from, to, unit, count, pixels) =>
        Array.from({ length: pixels + 1 }, (_, k) => Math.min(count, Math.max(0, (from + ((to - from) * k) / pixels) / unit)));
      const across = edges(place[0], place[1], per_column, columns, width);
      const along = edges(range[0], range[1], cell_m * pool, cells, height);
      const highest = new Uint8Array(cells);
      for (let x = 0; x < width; x++) {
        const first = Math.floor(across[x]);
        const stop = Math.max(first + 1, Math.ceil(across[x + 1] - 1e-9));
        highest.set(data.subarray(first * cells, (first + 1) * cells));
        for (let column = first + 1; column < Math.min(stop, columns); column++)
          for (let k = 0; k < cells; k++) if (data[column * cells + k] > highest[k]) highest[k] = data[column * cells + k];
        for (let y = 0; y < height; y++) {
          const begin = Math.min(cells - 1, Math.floor(along[y]));
          const end = Math.max(begin + 1, Math.min(cells, Math.ceil(along[y + 1] - 1e-9)));
          let value = highest[begin];
          for (let k = begin + 1; k < end; k++) if (highest[k] > value) value = highest[k];
          out[y * width + x] = colours[value];
        }
      }
    },
    colours() {
      const colour = paletteOf(this.now.palette);
      const [low, high] = this.now.limits;
      const [lowest, highest] = this.frame.scale_db;
      const table = new Uint32Array(256); // 0, no sample: transparent
      for (let value = 1; value < 256; value++)
        table[value] = pack(colour((lowest + ((highest - lowest) * value) / 255 - low) / (high - low)));
      return table;
    },
    drawOver() {
      if (!this.$refs.over || !this.isShown()) return;
      const { context, width, height } = prepare(this.$refs.over);
      context.textBaseline = "middle";
      context.textAlign = "left";
      context.fillStyle = ink();
      const heading = [this.now.title, this.frame?.caption, this.now.busy].filter(Boolean).join("  ·  ");
      context.fillText(heading, MARGIN.left, 12, width - MARGIN.left - 8);
      if (!this.frame) return context.fillText(this.now.busy ? "" : "nothing to show yet", MARGIN.left, 60);
      const box = this.box();
      this.drawAxes(context, box);
      this.drawStrips(context, box);
      this.clipped(context, box, () => this.drawLayers(context));
      this.drawCursor(context, box);
      drawScale(context, box, this.now.limits, this.now.palette);
      this.drawLegend(context, height);
      this.drawReading(context, width, height);
    },
    clipped(context, box, draw) {
      context.save();
      context.beginPath();
      context.rect(box.x, box.y, box.width, box.height);
      context.clip();
      draw();
      context.restore();
    },
    drawAxes(context, box) {
      const { place, range } = this.seen();
      context.fillStyle = ink();
      context.strokeStyle = gridInk();
      context.lineWidth = 1;
      context.textBaseline = "middle";
      context.textAlign = "center";
      for (const [value, text] of ticks(place[0], place[1], box.width / 90)) {
        if (!Number.isInteger(value)) continue;
        this.line(context, this.toX(value + 0.5), box.y, this.toX(value + 0.5), box.y + box.height);
        context.fillText(text, this.toX(value + 0.5), box.y + box.height + 9);
      }
      context.fillText("ping", box.x + box.width / 2, box.y + box.height + 22);
      context.textAlign = "right";
      for (const [value, text] of ticks(range[0], range[1], box.height / 45)) {
        this.line(context, box.x, this.toY(value), box.x + box.width, this.toY(value));
        context.fillText(text, box.x - 5, this.toY(value));
      }
      context.save();
      context.translate(12, box.y + box.height / 2);
      context.rotate(-Math.PI / 2);
      context.textAlign = "center";
      context.fillText("range, m", 0, 0);
      context.restore();
    },
    line(context, x1, y1, x2, y2) {
      context.beginPath();
      context.moveTo(x1, y1);
      context.lineTo(x2, y2);
      context.stroke();
    },
    drawStrips(context, box) {
      const dark = document.body.classList.contains("body--dark");
      this.strips().forEach((strip, row) => {
        const y = MARGIN.top + row * STRIP;
        context.fillStyle = ink();
        context.textAlign = "right";
        context.textBaseline = "middle";
        context.fillText(strip.name, box.x - 5, y + STRIP / 2);
        context.strokeStyle = gridInk();
        context.strokeRect(box.x, y + 1, box.width, STRIP - 3);
        context.save();
        context.beginPath();
        context.rect(box.x, y, box.width, STRIP);
        context.clip();
        context.fillStyle = strip.colours[dark ? 0 : 1];
        for (const { first, stop } of this.over[strip.of])
          context.fillRect(this.toX(first), y + 1, Math.max(2, this.toX(stop) - this.toX(first)), STRIP - 3);
        context.restore();
      });
    },
    drawLayers(context) {
      if (this.has("truth")) for (const way of this.over.truths) this.drawWay(context, way);
      if (this.has("echoes")) this.drawEchoes(context);
      if (this.has("tracks")) for (const way of this.over.tracks) this.drawWay(context, way);
      const named = new Set();
      const ways = [...(this.has("tracks") ? this.over.tracks : []), ...(this.has("truth") ? this.over.truths : [])];
      for (const way of ways) this.writeName(context, way, named);
    },
    drawEchoes(context) {
      const { place, range_m } = this.over.echoes;
      for (const [size, colour] of [[5, "rgba(0, 0, 0, 0.6)"], [3, ECHO]]) {
        context.fillStyle = colour;
        for (let k = 0; k < place.length; k++)
          context.fillRect(this.toX(place[k] + 0.5) - size / 2, this.toY(range_m[k]) - size / 2, size, size);
      }
    },
    drawWay(context, way) {
      const style = styleOf(way.role);
      const isMarked = way.id !== "" && way.id === String(this.now.marked);
      for (const [width, colour] of [[style.width + 2.5, "rgba(0, 0, 0, 0.6)"], [style.width + (isMarked ? 1.5 : 0), style.colour]]) {
        context.lineWidth = width;
        context.strokeStyle = colour;
        context.setLineDash(style.dash);
        context.beginPath();
        let joined = false;
        way.place.forEach((place, k) => {
          const range_m = way.range_m[k];
          if (range_m !== null) context[joined ? "lineTo" : "moveTo"](this.toX(place + 0.5), this.toY(range_m));
          joined = range_m !== null;
        });
        context.stroke();
      }
      context.setLineDash([]);
    },
    // Once for each object, where its line is first seen; a true one at its end.
    writeName(context, way, named) {
      const key = `${way.role === "truth"} ${way.label}`;
      if (named.has(key)) return;
      const { place, range } = this.seen();
      const isSeen = (k) =>
        way.range_m[k] !== null && way.place[k] >= place[0] && way.place[k] < place[1] && way.range_m[k] >= range[0] && way.range_m[k] <= range[1];
      const seen = way.place.map((_, k) => k).filter(isSeen);
      if (!seen.length) return;
      named.add(key);
      const at = way.role === "truth" ? seen[seen.length - 1] : seen[0];
      const [x, y] = [this.toX(way.place[at] + 0.5), this.toY(way.range_m[at])];
      context.textAlign = way.role === "truth" ? "right" : "left";
      context.textBaseline = "middle";
      halo(context, way.label, x + (way.role === "truth" ? -6 : 6), y - 10, styleOf(way.role).colour);
    },
    drawCursor(context, box) {
      const x = this.toX(this.now.cursor + 0.5);
      if (x < box.x || x > box.x + box.width) return;
      for (const [width, colour] of [[3, "rgba(0, 0, 0, 0.6)"], [1.2, styleOf("approach").colour]]) {
        context.lineWidth = width;
        context.strokeStyle = colour;
        this.line(context, x, MARGIN.top, x, box.y + box.height);
      }
    },
    drawLegend(context, height) {
      let x = MARGIN.left;
      const y = height - 27;
      const write = (role, label) => {
        if (x + 34 + context.measureText(label).width > this.$el.clientWidth) return;
        legend(context, [[role, label]], x, y);
        x += 44 + context.measureText(label).width;
      };
      if (this.has("echoes")) {
        context.fillStyle = ECHO;
        context.fillRect(x + 4, y - 2, 4, 4);
        context.textAlign = "left";
        context.textBaseline = "middle";
        context.fillStyle = ink();
        context.fillText("detection", x + 14, y);
        x += 30 + context.measureText("detection").width;
      }
      const roles = this.has("tracks") ? [...new Set(this.over.tracks.map((way) => way.role))] : [];
      for (const role of roles) write(role, legendOf(role));
      if (this.has("truth") && this.over.truths.length) write("truth", legendOf("truth"));
    },
    // What the pointer is on, in words; without a pointer how to go on.
    drawReading(context, width, height) {
      const spot = this.pointer && this.spotAt(...this.pointer);
      context.textAlign = "left";
      context.textBaseline = "middle";
      context.fillStyle = ink();
      const words = spot ? this.reading(spot) : "click: that ping   wheel: zoom   drag: pan   double click: all of it";
      context.fillText(words, MARGIN.left, height - 9, width - MARGIN.left - 8);
    },
    reading({ place, range_m, isInside }) {
      const { data, cells, per_column, cell_m, pool, scale_db, t_s } = this.frame;
      const column = Math.floor(place / per_column);
      const t = t_s[column];
      const words = [`ping ${place}${t === null ? "" : `, ${t.toFixed(1)} s`}`];
      if (isInside) {
        const value = data[column * cells + Math.min(cells - 1, Math.floor(range_m / (cell_m * pool)))];
        const level = scale_db[0] + ((scale_db[1] - scale_db[0]) * value) / 255;
        words.push(`${range_m.toFixed(2)} m`, value ? `${level.toFixed(1)} dB` : "no sample");
      }
      for (const { of, name } of this.strips())
        for (const span of this.over[of])
          if (place >= span.first && place < Math.max(span.stop, span.first + 1)) words.push(`${name}: ${span.why}`);
      return words.join("   ");
    },
    // -- the pointer --
    placeOf(event) {
      const bounds = this.$refs.over.getBoundingClientRect();
      return [event.clientX - bounds.left, event.clientY - bounds.top];
    },
    press(event) {
      const [x, y] = this.placeOf(event);
      if (event.button !== 0 || !this.spotAt(x, y)) return;
      this.$refs.over.setPointerCapture(event.pointerId);
      this.pressed = { x, y, moved: false, part: this.part };
    },
    move(event) {
      const [x, y] = (this.pointer = this.placeOf(event));
      const { pressed } = this;
      if (!pressed) return this.drawOver();
      pressed.moved = pressed.moved || Math.hypot(x - pressed.x, y - pressed.y) > STILL;
      if (!pressed.moved || !pressed.part) return this.drawOver();
      const box = this.box();
      const { place, range } = pressed.part;
      this.see({
        place: shifted(place, -((x - pressed.x) / box.width) * (place[1] - place[0]), this.frame.pings),
        range: shifted(range, -((y - pressed.y) / box.height) * (range[1] - range[0]), this.far_m),
      });
    },
    release(event) {
      const { pressed } = this;
      this.pressed = null;
      const spot = pressed && !pressed.moved ? this.spotAt(...this.placeOf(event)) : null;
      if (spot) this.$emit("pick", { place: spot.place });
    },
    leave() {
      this.pointer = null;
      this.drawOver();
    },
    zoom(event) {
      const spot = this.spotAt(...this.placeOf(event));
      if (!spot) return;
      event.preventDefault();
      const factor = event.deltaY < 0 ? 1 / 1.25 : 1.25;
      const { place, range } = this.seen();
      const part = {
        place: scaled(place, spot.at, factor, this.frame.pings), range: scaled(range, spot.range_m, factor, this.far_m),
      };
      const isAll = part.place[0] <= 0 && part.place[1] >= this.frame.pings;
      this.see(isAll ? null : part);
    },
    see(part) {
      this.part = part;
      if (this.waits) return;
      this.waits = true;
      requestAnimationFrame(() => {
        this.waits = false;
        this.redraw();
      });
    },
  },
};

// Part of 0 to `most`, moved; it stays within.
function shifted([from, to], by, most) {
  const shift = Math.min(most - to, Math.max(-from, by));
  return [from + shift, to + shift];
}

// Part of 0 to `most`, made longer or shorter about a place that stays where it is.
function scaled([from, to], about, factor, most) {
  const length = Math.min(most, Math.max(most / MOST_ZOOM, (to - from) * factor));
  const begin = about - ((about - from) / (to - from)) * length;
  return shifted([begin, begin + length], 0, most);
}
