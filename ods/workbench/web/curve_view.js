// Curves over one axis, with lines across that may be dragged: range profiles and histograms.
import { CANVAS, gridInk, halo, ink, legend, onCanvas, prepare, styleOf, ticks } from "ods-charts";

const MARGIN = { left: 46, right: 12, top: 24, bottom: 32 };
const NEAR = 7; // pixels from a line that still catch it
const TOLD_MS = 50;

export default {
  mixins: [onCanvas],
  template: CANVAS,
  props: { shown: String },
  created() {
    this.take(this.shown);
    this.caught = null; // the line that is dragged
    this.told = 0;
  },
  mounted() {
    this.$el.curveView = this;
  },
  methods: {
    heard() {
      return {
        pointerdown: (event) => this.press(event),
        pointermove: (event) => this.move(event),
        pointerup: (event) => this.release(event),
      };
    },
    show(text) {
      this.take(text);
      this.draw();
    },
    take(text) {
      this.now = { title: "", x: null, y: null, curves: [], lines: [], ...JSON.parse(text) };
      const held = this.caught && this.now.lines.find((line) => line.name === this.caught.name);
      if (held) held.value = this.caught.value; // the hand is newer than the answer
    },
    box() {
      return this.inside(MARGIN);
    },
    toX(value) {
      const box = this.box();
      return box.x + ((value - this.now.x.low) / (this.now.x.high - this.now.x.low)) * box.width;
    },
    toY(value) {
      const box = this.box();
      return box.y + box.height - ((value - this.now.y.low) / (this.now.y.high - this.now.y.low)) * box.height;
    },
    valueAt(line, event) {
      const box = this.box();
      const [x, y] = this.placeOf(event);
      const across = line.axis === "x";
      const share = across ? (x - box.x) / box.width : 1 - (y - box.y) / box.height;
      const axis = across ? this.now.x : this.now.y;
      return axis.low + Math.min(1, Math.max(0, share)) * (axis.high - axis.low);
    },
    lineAt(event) {
      if (!this.now.x) return null;
      const [x, y] = this.placeOf(event);
      const apart = (line) => Math.abs(line.axis === "x" ? this.toX(line.value) - x : this.toY(line.value) - y);
      const near = this.now.lines.filter((line) => line.draggable && apart(line) <= NEAR);
      return near.sort((one, other) => apart(one) - apart(other))[0] || null;
    },
    press(event) {
      this.caught = event.button === 0 ? this.lineAt(event) : null;
      if (this.caught) this.$refs.canvas.setPointerCapture(event.pointerId);
    },
    move(event) {
      const line = this.caught || this.lineAt(event);
      this.$refs.canvas.style.cursor = line ? (line.axis === "x" ? "ew-resize" : "ns-resize") : "default";
      if (!this.caught) return;
      this.drag(event, performance.now() - this.told >= TOLD_MS);
    },
    release(event) {
      if (this.caught) this.drag(event, true);
      this.caught = null;
    },
    drag(event, tells) {
      this.caught.value = this.valueAt(this.caught, event);
      if (tells) {
        this.told = performance.now();
        this.$emit("drag", { name: this.caught.name, value: this.caught.value });
      }
      this.draw();
    },
    // -- drawing --
    draw() {
      const prepared = this.$refs.canvas && prepare(this.$refs.canvas);
      if (!prepared) return;
      const { context, width, height } = prepared;
      context.textBaseline = "middle";
      context.fillStyle = ink();
      const box = this.box();
      this.heading(context, box);
      if (!this.now.x) return;
      this.axes(context, box, height);
      context.save();
      context.beginPath();
      context.rect(box.x, box.y, box.width, box.height);
      context.clip();
      for (const curve of this.now.curves) this.curve(context, curve);
      context.restore();
      for (const line of this.now.lines) this.line(context, box, line);
      const entries = this.now.curves.filter((curve) => curve.label).map((curve) => [curve.role, curve.label]);
      const longest = Math.max(0, ...entries.map(([, label]) => context.measureText(label).width));
      legend(context, entries, box.x + box.width - longest - 38, box.y + 12, 16);
    },
    heading(context, box) {
      // Title and what the heights are, side by side; narrower letters where both have no room.
      const [title, label] = [this.now.title, this.now.y ? this.now.y.label : ""];
      const [titleWidth, labelWidth] = [title, label].map((text) => context.measureText(text).width);
      const share = Math.min(1, Math.max(0.1, (box.x + box.width - 24) / (titleWidth + labelWidth || 1)));
      context.textAlign = "left";
      context.fillText(title, 8, 12, share * titleWidth);
      context.textAlign = "right";
      context.fillText(label, box.x + box.width, 12, share * labelWidth);
    },
    axes(context, box, height) {
      context.strokeStyle = gridInk();
      context.lineWidth = 1;
      context.fillStyle = ink();
      context.textAlign = "center";
      for (const [value, text] of ticks(this.now.x.low, this.now.x.high, box.width / 70)) {
        const x = this.toX(value);
        context.beginPath();
        context.moveTo(x, box.y);
        context.lineTo(x, box.y + box.height);
        context.stroke();
        context.fillText(text, x, box.y + box.height + 10);
      }
      context.fillText(this.now.x.label, box.x + box.width / 2, height - 8);
      context.textAlign = "right";
      for (const [value, text] of ticks(this.now.y.low, this.now.y.high, box.height / 30)) {
        const y = this.toY(value);
        context.beginPath();
        context.moveTo(box.x, y);
        context.lineTo(box.x + box.width, y);
        context.stroke();
        if (!this.now.y.log) context.fillText(text, box.x - 5, y);
        else if (Number.isInteger(value)) context.fillText(value < 3 ? String(10 ** value) : `${10 ** (value - 3)}k`, box.x - 5, y);
      }
    },
    curve(context, { role, x0, dx, values, filled }) {
      const style = styleOf(role);
      context.strokeStyle = context.fillStyle = style.colour;
      context.lineWidth = 1.3;
      context.setLineDash([]);
      context.beginPath();
      let down = false;
      const floor = this.toY(this.now.y.low);
      values.forEach((value, place) => {
        const x = this.toX(x0 + place * dx);
        if (filled) {
          if (value !== null) context.rect(x, this.toY(value), Math.max(1, this.toX(x0 + (place + 1) * dx) - x), floor - this.toY(value));
          return;
        }
        if (value !== null) down ? context.lineTo(x, this.toY(value)) : context.moveTo(x, this.toY(value));
        down = value !== null;
      });
      if (!filled) return context.stroke();
      context.globalAlpha = 0.55;
      context.fill();
      context.globalAlpha = 1;
    },
    line(context, box, line) {
      const across = line.axis === "x";
      const at = across ? this.toX(line.value) : this.toY(line.value);
      const [low, size] = across ? [box.x, box.width] : [box.y, box.height];
      if (!(at >= low - 1 && at <= low + size + 1)) return;
      const style = styleOf(line.role);
      context.strokeStyle = style.colour;
      context.lineWidth = line.draggable ? 2 : 1.2;
      context.setLineDash(line.draggable ? [] : [4, 3]);
      context.beginPath();
      context.moveTo(across ? at : box.x, across ? box.y : at);
      context.lineTo(across ? at : box.x + box.width, across ? box.y + box.height : at);
      context.stroke();
      context.setLineDash([]);
      const isLow = line.name === "low"; // on the side where the other line is not
      context.textAlign = across && isLow ? "right" : "left";
      if (across) halo(context, line.name, at + (isLow ? -4 : 4), box.y + 8, style.colour);
      else if (line.name) halo(context, line.name, box.x + 4, at + (isLow ? 9 : -8), style.colour);
    },
  },
};
