// Curves in panels over one axis, and strips of states, by ECharts. Wheel: zoom (Shift: move on); drag: a line, or a box to
// zoom into, or the time; double click: all again. What is pointed at shows in all views that have the axis.
import { echarts } from "nicegui-echart";
import { cornerButton, ink, onPaper, paper, saveAs, styleOf, watch, withPicture } from "ods-charts";
import { followCursors, pointAt } from "ods-charts/cursors.js";
import { withKeys } from "ods-charts/keys.js";
import { csvOf, described, limitsOf, wholeOf } from "ods-charts/described.js";
import { arranged, optionsOf } from "ods-charts/options.js";
import { overlay } from "ods-charts/overlay.js";
import { Places } from "ods-charts/places.js";

const SENT_MS = 50;
const REPLACED = ["title", "grid", "xAxis", "yAxis", "series"]; // where there are other parts than before
const READOUT = "position: absolute; pointer-events: none; display: none; padding: 2px 6px; border-radius: 4px; z-index: 2; " +
  "font-size: 12px; white-space: pre; border: 1px solid rgba(128, 128, 128, 0.5)";
let views = 0;

export default {
  template: `
    <div style="position: relative; width: 100%; height: 100%; min-height: 120px; overflow: hidden">
      <div ref="chart" style="position: absolute; inset: 0; touch-action: none"></div>
      <div ref="readout" style="${READOUT}"></div>
    </div>`,
  props: { shown: String, title: String, busy: String, cursor: Number, picks: Boolean },
  created() {
    this.now = { ...this.$props }; // as the page has set them since
    this.own = `view ${views++}`; // name of axes that no other view has
    this.part = { x: null, y: {} }; // of the axes, what is shown; null: all
    this.sent = 0;
    this.pressed = this.chart = this.places = this.due = null;
    this.pointed = {};
    this.take();
  },
  mounted() {
    this.$el.chartView = this;
    const ends = [watch(this.$el, () => this.drawSoon()), followCursors((places) => this.point(places))];
    this.unwatch = () => ends.forEach((end) => end());
    const name = () => this.now.title || this.about.panels[0]?.y.label || "chart";
    withPicture(this.$el, name);
    cornerButton(this.$el, "print", "download this chart for print (SVG)", 26, () => saveAs(name(), "svg", this.svg(), "image/svg+xml"));
    cornerButton(this.$el, "table_view", "download its numbers (CSV)", 46, () => saveAs(name(), "csv", csvOf(this.about), "text/csv"));
    const listeners = {
      pointerdown: this.press, pointermove: this.move, pointerup: this.release, pointerleave: this.leave,
      wheel: this.zoom, dblclick: this.showAll,
    };
    for (const [event, listener] of Object.entries(listeners)) this.$refs.chart.addEventListener(event, listener, { passive: event !== "wheel" });
    withKeys(this.$el, this.$refs.chart, name());
    this.draw();
    this.$emit("mounted"); // in a tab that was not shown nothing was listeners
  },
  beforeUnmount() {
    this.unwatch();
    cancelAnimationFrame(this.due);
    this.chart?.dispose();
  },
  methods: {
    // -- what the page says --
    set(name, value) {
      this.now[name] = value;
      if (name === "shown") this.take();
      if (name === "cursor") this.drawMarks();
      else this.drawSoon();
    },
    // What is zoomed into stays so, unless the whole is another. The hand is newer than the answer.
    take() {
      this.about = described(this.now.shown);
      const { x, panels } = this.about;
      if (x) x.cursor ||= this.own;
      const held = this.pressed?.line;
      for (const line of panels.flatMap((panel) => panel.lines))
        if (held && line.name === held.name) this.pressed.line = Object.assign(line, { value: held.value });
      const axes = JSON.stringify([x, panels.map(({ title, y }) => [title, y.label])]);
      if (axes !== this.axes) this.part = { x: null, y: {} };
      this.axes = axes;
    },
    // -- the pointer --
    under({ clientX, clientY }) {
      const bounds = this.$refs.chart.getBoundingClientRect();
      return this.places?.under(clientX - bounds.left, clientY - bounds.top) ?? { box: null, place: -1, strip: null };
    },
    press(event) {
      const at = this.under(event);
      if (event.button !== 0) return;
      if (at.strip !== null) this.$emit("mark", { id: this.about.strips[at.strip].id });
      if (!at.box) return;
      this.$refs.chart.setPointerCapture(event.pointerId);
      const line = this.places.lineAt(at);
      this.pressed = { at, line, does: line ? "line" : this.now.picks && !event.shiftKey ? "pick" : "frame" };
      if (this.pressed.does === "pick") this.pick(at, true);
    },
    move(event) {
      if (this.pressed) this[this.pressed.does](this.under(event), false);
      else this.hover(this.under(event));
    },
    release(event) {
      if (this.pressed) this[this.pressed.does](this.under(event), true);
      this.pressed = null;
      this.drawMarks();
    },
    leave() {
      if (!this.pressed) this.hover({ place: -1, box: null });
    },
    line({ x, y }, last) {
      const { line, at } = this.pressed;
      line.value = this.places.valueOf(line, at, x, y);
      this.send("drag", { name: line.name, value: line.value }, last);
      this.drawSoon();
    },
    pick({ x }, last) {
      const [from, to] = this.places.ends.x;
      this.send("pick", { x: Math.min(to, Math.max(from, this.places.xAt(this.pressed.at.box, x))) }, last);
    },
    frame(to, last) {
      const { at } = this.pressed;
      this.pressed.frame = this.places.frame(at, to);
      const part = last && this.pressed.frame && this.places.framed(at, this.pressed.frame);
      if (!part) return this.drawMarks();
      this.part = { x: part.x, y: part.y ? { ...this.part.y, [at.place]: part.y } : this.part.y };
      this.drawSoon();
    },
    // Not more often than the page can follow; the newest, and the last in any case.
    send(event, what, last) {
      if (!last && performance.now() - this.sent < SENT_MS) return;
      this.sent = performance.now();
      this.$emit(event, what);
    },
    zoom(event) {
      const at = this.under(event);
      if (!at.box) return;
      event.preventDefault();
      this.part.x = this.places.zoomed(at, event.deltaY || event.deltaX, event.shiftKey);
      this.drawSoon();
    },
    showAll() {
      this.part = { x: null, y: {} };
      this.drawSoon();
    },
    hover(at) {
      const { x, panels } = this.about;
      const line = at.box && this.places.lineAt(at);
      if (at.box) this.chart.getZr().setCursorStyle(line ? (line.axis === "x" ? "ew-resize" : "ns-resize") : "crosshair");
      const pointed = at.box ? { [x.cursor]: this.places.xAt(at.box, at.x) } : {};
      const level = at.place >= 0 ? panels[at.place].y.cursor : "";
      if (level) pointed[level] = this.places.yAt(at.place, at.y);
      pointAt(pointed);
      this.read(at);
    },
    // Writes beside the pointer what is there.
    read(at) {
      const { readout } = this.$refs;
      readout.style.display = at.box ? "block" : "none";
      if (!at.box) return;
      readout.replaceChildren(...this.places.reading(at).map(([role, text]) => {
        const style = role ? `color: ${styleOf(role).colour}` : "";
        return Object.assign(document.createElement("div"), { textContent: text, style });
      }));
      const beside = at.x + 14 + readout.offsetWidth > this.$el.clientWidth ? at.x - 14 - readout.offsetWidth : at.x + 14;
      const below = Math.min(at.y + 12, this.$el.clientHeight - readout.offsetHeight - 2);
      const place = { left: `${Math.max(0, beside)}px`, top: `${Math.max(0, below)}px` };
      Object.assign(readout.style, { ...place, background: paper(), color: ink() });
    },
    // -- drawing --
    drawSoon() {
      this.due ??= requestAnimationFrame(() => this.draw());
    },
    draw() {
      cancelAnimationFrame(this.due);
      this.due = null;
      const { clientWidth: width, clientHeight: height } = this.$el;
      if (!width || !height) return;
      this.chart ??= echarts.init(this.$refs.chart, null, { width, height });
      if (this.chart.getWidth() !== width || this.chart.getHeight() !== height) this.chart.resize({ width, height });
      const options = this.options(width, height);
      const parts = JSON.stringify(REPLACED.map((kind) => options[kind].map(({ id }) => id)));
      this.chart.setOption(options, parts === this.parts ? {} : { replaceMerge: REPLACED }); // which takes longer
      this.parts = parts;
      this.$refs.chart.style.opacity = this.now.busy ? 0.5 : 1;
      this.drawMarks();
    },
    options(width, height) {
      const { about, part } = this;
      const title = [this.now.title, this.now.busy].filter(Boolean).join("  ·  ");
      const laid = about.panels.length + about.strips.length ? arranged(about, [width, height], Boolean(title)) : null;
      this.places = null;
      if (!laid) return nothing(about.panels.length ? "" : this.now.busy || "nothing to show yet");
      const whole = wholeOf(about);
      const x = part.x || whole;
      const y = about.panels.map((panel, place) => part.y[place] || limitsOf(panel, x));
      this.places = new Places(about, laid, { x, y }, whole);
      return optionsOf(about, laid, { x, y, whole: !part.x }, title);
    },
    // For paper: light, without what is pointed at.
    svg() {
      const { clientWidth: width, clientHeight: height } = this.$el;
      const printed = echarts.init(null, null, { renderer: "svg", ssr: true, width, height });
      onPaper(() => printed.setOption({ ...this.options(width, height), backgroundColor: paper() }));
      const text = printed.renderToSVGString();
      printed.dispose();
      return text;
    },
    point(pointed) {
      this.pointed = pointed;
      if (this.chart && this.$el.clientWidth) this.drawMarks();
    },
    drawMarks() {
      if (!this.chart) return;
      const { cursor } = this.now;
      for (const mark of this.marks || []) this.chart.getZr().remove(mark);
      const { pointed, pressed } = this;
      this.marks = this.places ? overlay(echarts.graphic, this.places, { cursor, pointed, frame: pressed?.frame }) : [];
      for (const mark of this.marks) this.chart.getZr().add(mark);
    },
  },
};

function nothing(text) {
  const title = { id: "title", text, left: "center", top: "middle", textStyle: { color: ink(), fontSize: 12, fontWeight: "normal" } };
  return { title: [title], legend: { id: "legend", show: false }, grid: [], xAxis: [], yAxis: [], series: [] };
}
