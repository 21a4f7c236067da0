// Values over time in panels, and above them a strip for each object with the states of its life; one cursor in all.
import { CANVAS, gridInk, halo, ink, onCanvas, prepare, styleOf, ticks } from "ods-charts";

const MARGIN = { left: 52, right: 12, top: 24, bottom: 40 };
const LABEL = { least: 84, most: 190 }; // of a strip's name
const ROW = 17;
const GAP = { across: 54, down: 22 };
const STILL = 4;
const SCRUB_MS = 60;

export default {
  mixins: [onCanvas],
  template: CANVAS,
  props: { shown: String, columns: Number, title: String, busy: String, cursor: Number },
  created() {
    this.now = { ...this.$props }; // as the page has set them since
    this.part = null; // [from, to], s: the part of the time that is shown; null: all
    this.take();
    this.pressed = this.pointer = null;
    this.boxes = [];
  },
  mounted() {
    this.$el.timeView = this;
    this.$refs.canvas.style.cursor = "crosshair";
  },
  methods: {
    heard() {
      return {
        pointerdown: (event) => this.press(event),
        pointermove: (event) => this.move(event),
        pointerup: () => (this.pressed = null),
        pointerleave: () => this.leave(),
        wheel: (event) => this.zoom(event),
        dblclick: () => this.showAll(),
      };
    },
    // What is zoomed into stays so, unless the whole is another.
    take() {
      const { span = null, panels = [], strips = [] } = JSON.parse(this.now.shown);
      if (span?.[0] !== this.whole?.[0] || span?.[1] !== this.whole?.[1]) this.part = null;
      this.whole = span;
      this.panels = panels;
      this.strips = strips;
    },
    set(name, value) {
      this.now[name] = value;
      if (name === "shown") this.take();
      this.draw();
    },
    showAll() {
      this.part = null;
      this.draw();
    },
    // -- the pointer --
    boxAt(x, y) {
      return this.boxes.find((box) => x >= box.x - 4 && x <= box.x + box.width + 4 && y >= box.y - 4 && y <= box.y + box.height + 4);
    },
    timeAt(box, x) {
      const [from, to] = this.range();
      return Math.min(to, Math.max(from, from + ((x - box.x) / box.width) * (to - from)));
    },
    range() {
      return this.part || this.whole;
    },
    press(event) {
      const [x, y] = this.placeOf(event);
      const row = (this.rows || []).find((each) => y >= each.y && y < each.y + ROW);
      const box = this.boxAt(x, y);
      if (row && event.button === 0) this.$emit("mark", { id: row.id });
      if (!box || event.button !== 0) return;
      this.$refs.canvas.setPointerCapture(event.pointerId);
      this.pressed = { box, told: 0 };
      this.scrub(x);
    },
    move(event) {
      const [x, y] = this.placeOf(event);
      this.pointer = this.boxAt(x, y) ? [x, y] : null;
      if (this.pressed) this.scrub(x);
      this.draw();
    },
    scrub(x) {
      const now = performance.now();
      if (now - this.pressed.told < SCRUB_MS) return;
      this.pressed.told = now;
      this.$emit("pick", { t_s: this.timeAt(this.pressed.box, x) });
    },
    leave() {
      this.pointer = null;
      this.draw();
    },
    zoom(event) {
      const [x, y] = this.placeOf(event);
      const box = this.boxAt(x, y);
      if (!box || !this.whole) return;
      event.preventDefault();
      const [from, to] = this.range();
      const t = this.timeAt(box, x);
      const factor = Math.exp(0.0015 * event.deltaY);
      const wider = [Math.max(this.whole[0], t - (t - from) * factor), Math.min(this.whole[1], t + (to - t) * factor)];
      if (wider[1] - wider[0] > 0.05) this.part = wider;
      this.draw();
    },
    // -- drawing --
    draw() {
      const prepared = this.$refs.canvas && prepare(this.$refs.canvas);
      if (!prepared) return;
      const { context, width, height } = prepared;
      context.textBaseline = "middle";
      context.textAlign = "left";
      context.fillStyle = ink();
      context.fillText([this.now.title, this.now.busy].filter(Boolean).join("  ·  "), 10, 12, width - 14);
      this.boxes = [];
      if (!this.whole || this.whole[1] <= this.whole[0]) return this.nothing(context, width, height);
      context.globalAlpha = this.now.busy ? 0.4 : 1;
      const below = this.drawStrips(context, width);
      this.drawPanels(context, width, height, below);
      this.drawCursor(context);
      context.globalAlpha = 1;
      this.drawPointer(context);
    },
    toX(box, t) {
      const [from, to] = this.range();
      return box.x + ((t - from) / (to - from)) * box.width;
    },
    drawStrips(context, width) {
      this.rows = [];
      if (!this.strips.length) return MARGIN.top + 14;
      context.font = "bold 12px system-ui, sans-serif";
      const widest = Math.max(...this.strips.map((strip) => context.measureText(`▸ ${strip.label}`).width));
      const left = Math.min(LABEL.most, Math.max(LABEL.least, widest + 12));
      const box = { x: left, y: MARGIN.top, width: width - left - MARGIN.right, height: ROW * this.strips.length };
      context.font = "12px system-ui, sans-serif";
      this.boxes.push(box);
      this.timeAxis(context, box, true);
      this.strips.forEach((strip, place) => {
        const y = box.y + place * ROW;
        this.rows.push({ id: strip.id, y });
        context.textAlign = "right";
        context.textBaseline = "middle";
        context.fillStyle = ink();
        context.font = `${strip.marked ? "bold " : ""}12px system-ui, sans-serif`;
        context.fillText((strip.marked ? "▸ " : "") + strip.label, box.x - 8, y + ROW / 2, box.x - 10);
        this.clipped(context, box, () => {
          for (const [role, from, to] of strip.spans) this.drawSpan(context, box, role, from, to, y);
        });
      });
      context.font = "12px system-ui, sans-serif";
      const end = box.y + box.height + MARGIN.bottom;
      return this.stripLegend(context, width, end);
    },
    drawSpan(context, box, role, from, to, y) {
      const style = styleOf(role);
      const [x1, x2] = [this.toX(box, from), this.toX(box, to)];
      context.fillStyle = context.strokeStyle = style.colour;
      if (role === "tentative" || role === "hibernated") {
        // told by their pattern, too: outline, and half height
        context.lineWidth = 1.5;
        const high = role === "tentative" ? 9 : 5;
        context.strokeRect(x1, y + (ROW - high) / 2, Math.max(1.5, x2 - x1), high);
      } else {
        const high = role === "active" ? 11 : 5;
        context.fillRect(x1, y + (ROW - high) / 2, Math.max(2, x2 - x1), high);
      }
    },
    stripLegend(context, width, y) {
      let x = MARGIN.right;
      context.textAlign = "left";
      for (const role of ["tentative", "active", "stand_by", "hibernated", "terminated"]) {
        const label = styleOf(role).label;
        const wide = 28 + context.measureText(label).width;
        if (x + wide > width) [x, y] = [MARGIN.right, y + ROW];
        const part = this.part;
        this.part = [0, 1];
        this.drawSpan(context, { x, width: 22 }, role, 0, 1, y - ROW / 2);
        this.part = part;
        context.fillStyle = ink();
        context.fillText(label, x + 28, y);
        x += wide + 16;
      }
      return y + 26;
    },
    drawPanels(context, width, height, top) {
      const { panels, columns } = this;
      if (!panels.length) return;
      const lines = Math.ceil(panels.length / columns);
      const wide = (width - MARGIN.left - MARGIN.right - (columns - 1) * GAP.across) / columns;
      const high = (height - top - 8 - MARGIN.bottom - (lines - 1) * GAP.down) / lines;
      if (high < 20 || wide < 40) return;
      panels.forEach((panel, place) => {
        const [column, line] = [place % columns, Math.floor(place / columns)];
        const box = {
          x: MARGIN.left + column * (wide + GAP.across), y: top + 8 + line * (high + GAP.down), width: wide, height: high,
        };
        this.boxes.push(box);
        this.drawPanel(context, box, panel, place + columns >= panels.length);
      });
    },
    drawPanel(context, box, panel, last) {
      const [low, high] = this.limits(panel);
      const toY = (value) => box.y + box.height - ((value - low) / (high - low)) * box.height;
      this.timeAxis(context, box, last);
      context.textAlign = "right";
      for (const [value, text] of ticks(low, high, Math.max(3, box.height / 24))) {
        this.line(context, box.x, toY(value), box.x + box.width, toY(value), gridInk());
        context.fillStyle = ink();
        context.fillText(text, box.x - 5, toY(value));
      }
      this.clipped(context, box, () => {
        for (const band of panel.bands) this.drawBand(context, box, band, toY);
        for (const line of panel.lines) this.drawLine(context, box, line, toY);
      });
      context.textAlign = "left";
      context.textBaseline = "middle";
      halo(context, panel.title, box.x, box.y - 9);
      let x = box.x + box.width;
      context.textAlign = "right";
      const named = box.x + context.measureText(panel.title).width + 10;
      for (const line of [...panel.lines].reverse()) {
        const wide = context.measureText(line.label).width;
        if (x - wide < named) return; // no room beside the title
        halo(context, line.label, x, box.y - 9, styleOf(line.role).colour);
        x -= wide + 10;
      }
    },
    limits(panel) {
      const [from, to] = this.range();
      let [low, high] = [Infinity, -Infinity];
      const take = (t, values) => {
        for (let k = 0; k < t.length; k++) {
          if (values[k] === null || t[k] < from || t[k] > to) continue;
          low = Math.min(low, values[k]);
          high = Math.max(high, values[k]);
        }
      };
      for (const line of panel.lines) take(line.t_s, line.values);
      const [inner, outer] = [low, high];
      for (const band of panel.bands) for (const edge of [band.low, band.high]) take(band.t_s, edge);
      if (low > high) return [0, 1];
      // a band may run away: it is shown up to twice the height of the curves
      const room = Math.max(outer - inner, panel.least);
      [low, high] = [Math.max(low, inner - room), Math.min(high, outer + room)];
      const more = Math.max(0.06 * (high - low), 0.5 * (panel.least - (high - low)));
      return [low - more, high + more];
    },
    drawBand(context, box, band, toY) {
      context.fillStyle = styleOf(band.role).colour;
      const alpha = context.globalAlpha;
      context.globalAlpha = 0.2 * alpha;
      const parts = [];
      let part = [];
      band.t_s.forEach((t, k) => {
        if (band.low[k] === null) {
          parts.push(part);
          part = [];
        } else part.push(k);
      });
      for (const each of [...parts, part]) {
        context.beginPath();
        each.forEach((k) => context.lineTo(this.toX(box, band.t_s[k]), toY(band.high[k])));
        [...each].reverse().forEach((k) => context.lineTo(this.toX(box, band.t_s[k]), toY(band.low[k])));
        context.fill();
      }
      context.globalAlpha = alpha;
    },
    drawLine(context, box, line, toY) {
      const style = styleOf(line.role);
      context.strokeStyle = style.colour;
      context.lineWidth = style.width;
      context.setLineDash(style.dash);
      context.beginPath();
      let joined = false;
      line.t_s.forEach((t, k) => {
        const value = line.values[k];
        if (value !== null) context[joined ? "lineTo" : "moveTo"](this.toX(box, t), toY(value));
        joined = value !== null;
      });
      context.stroke();
      context.setLineDash([]);
    },
    timeAxis(context, box, named) {
      const [from, to] = this.range();
      context.textAlign = "center";
      context.textBaseline = "middle";
      for (const [t, text] of ticks(from, to, box.width / 70)) {
        const x = this.toX(box, t);
        this.line(context, x, box.y, x, box.y + box.height, gridInk());
        context.fillStyle = ink();
        if (named) context.fillText(text, x, box.y + box.height + 9);
      }
      if (named) context.fillText("time, s", box.x + box.width / 2, box.y + box.height + 22);
      context.strokeStyle = gridInk();
      context.strokeRect(box.x, box.y, box.width, box.height);
    },
    drawCursor(context) {
      const [from, to] = this.range();
      const t = this.now.cursor;
      if (t < from || t > to) return;
      for (const box of this.boxes) {
        const x = this.toX(box, t);
        this.line(context, x, box.y, x, box.y + box.height, styleOf("approach").colour);
      }
    },
    clipped(context, box, draw) {
      context.save();
      context.beginPath();
      context.rect(box.x, box.y, box.width, box.height);
      context.clip();
      draw();
      context.restore();
    },
    line(context, x1, y1, x2, y2, colour) {
      context.strokeStyle = colour;
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(x1, y1);
      context.lineTo(x2, y2);
      context.stroke();
    },
    drawPointer(context) {
      if (!this.pointer) return;
      const [x, y] = this.pointer;
      const box = this.boxAt(x, y);
      if (!box) return;
      this.line(context, x, box.y, x, box.y + box.height, ink());
      context.textAlign = x > box.x + box.width / 2 ? "right" : "left";
      context.textBaseline = "middle";
      halo(context, `${this.timeAt(box, x).toFixed(1)} s`, x + (x > box.x + box.width / 2 ? -6 : 6), box.y + 9);
    },
  },
};
