// A plan in metres, north up: shapes in layers, that the page replaces one by one. Handles can be dragged.
import { CANVAS, gridInk, halo, ink, Labels, legend, legendOf, legendRows, onCanvas, paper, prepare, styleOf, ticks } from "ods-charts";
import { drawRuler, measures, withRuler } from "ods-charts/ruler.js";

const MARGIN = { left: 58, right: 12, top: 26, bottom: 40 };
const REACH = 10; // pixels from a handle that still catch it
const STILL = 4; // pixels of movement that are still a click
const DRAG_MS = 60; // between two events of a drag

export default {
  mixins: [onCanvas],
  template: CANVAS,
  props: { layers: Object, title: String, busy: String, fitted: Number, follows: Boolean },
  created() {
    this.now = { title: this.title, busy: this.busy }; // as the page has set them since
    this.take(this.layers);
    this.touched = false; // zoomed or panned since all of it was shown
    this.view = null; // {north, east, scale}: middle, pixels a metre
    this.pressed = this.pointer = null;
    this.measured = null; // [from, to]: places
    this.legendHeight = 0; // below the axis
  },
  mounted() {
    this.$el.planView = this;
    this.unruled = withRuler(this.$el, () => this.forget());
  },
  beforeUnmount() {
    this.unruled();
  },
  watch: {
    layers() {
      this.take(this.layers);
      this.draw();
    },
  },
  methods: {
    listeners() {
      return {
        pointerdown: (event) => this.press(event),
        pointermove: (event) => this.move(event),
        pointerup: (event) => this.release(event),
        pointerleave: () => this.leave(),
        wheel: (event) => this.zoom(event),
        dblclick: () => this.fit(),
      };
    },
    take(layers) {
      this.shown = Object.fromEntries(Object.entries(layers).map(([name, text]) => [name, JSON.parse(text)]));
    },
    set(name, value) {
      this.now[name] = value;
      if (name === "fitted") this.fit();
      else this.draw();
    },
    setLayer(name, text) {
      this.shown[name] = JSON.parse(text);
      this.keepDragging();
      if (this.follows && !this.touched && !this.pressed && this.view && !this.showsAll()) this.view = null;
      this.draw();
    },
    // What is dragged stays under the pointer, though the page sends it anew.
    keepDragging() {
      const dragged = this.pressed?.handle;
      if (!dragged) return;
      const again = this.handles().find((shape) => shape.id === dragged.id);
      if (again) this.pressed.handle = Object.assign(again, { at: dragged.at });
      else this.pressed = null;
    },
    fit() {
      this.view = null;
      this.touched = false;
      this.draw();
    },
    // -- geometry --
    all() {
      return Object.values(this.shown).flat();
    },
    handles() {
      return this.all().filter((shape) => shape.kind === "handle");
    },
    box() {
      return this.inside({ ...MARGIN, bottom: MARGIN.bottom + this.legendHeight });
    },
    // What is to be seen when all of it is: [lowest north, highest, lowest east, highest]; null: nothing is there. Of the
    // sonar's sector only where there is nothing in it.
    extent() {
      const [north, east] = [[], []];
      const take = ([n, e], around = 0) => {
        north.push(n - around, n + around);
        east.push(e - around, e + around);
      };
      const shapes = this.all();
      const isAlone = shapes.every((shape) => ["vehicle", "sector"].includes(shape.role) || shape.kind === "handle");
      for (const shape of shapes) {
        if (shape.points && (isAlone || shape.role !== "sector")) shape.points.forEach((point) => take(point));
        else if (shape.at && shape.kind !== "ellipse") take(shape.at, shape.radius_m || 0);
      }
      return north.length ? [Math.min(...north), Math.max(...north), Math.min(...east), Math.max(...east)] : null;
    },
    showsAll() {
      const [lowN, highN, lowE, highE] = this.extent() ?? [0, 0, 0, 0];
      const box = this.box();
      const [left, top] = this.toCanvas([highN, lowE]);
      const [right, bottom] = this.toCanvas([lowN, highE]);
      return left >= box.x && top >= box.y && right <= box.x + box.width && bottom <= box.y + box.height;
    },
    whole() {
      const box = this.box();
      const extent = this.extent();
      if (!extent) return { north: 0, east: 0, scale: box.height / 100 };
      const [lowN, highN, lowE, highE] = extent;
      const scale = 0.88 * Math.min(box.width / Math.max(5, highE - lowE), box.height / Math.max(5, highN - lowN));
      return { north: 0.5 * (lowN + highN), east: 0.5 * (lowE + highE), scale };
    },
    toCanvas([north, east]) {
      const { view } = this;
      const box = this.box();
      return [
        box.x + 0.5 * box.width + (east - view.east) * view.scale,
        box.y + 0.5 * box.height - (north - view.north) * view.scale,
      ];
    },
    toPlace(x, y) {
      const { view } = this;
      const box = this.box();
      return [
        view.north - (y - box.y - 0.5 * box.height) / view.scale,
        view.east + (x - box.x - 0.5 * box.width) / view.scale,
      ];
    },
    // -- the pointer --
    handleAt(x, y) {
      const away = (shape) => {
        const [hx, hy] = this.toCanvas(shape.at);
        return Math.hypot(hx - x, hy - y);
      };
      const near = this.handles().map((shape) => [away(shape), shape]).filter(([distance]) => distance <= REACH);
      return near.sort((one, other) => one[0] - other[0])[0]?.[1];
    },
    // The smallest shape with an id that the place is in or near.
    idAt(x, y) {
      const hits = [];
      for (const shape of this.all()) {
        if (!shape.id || !shape.at) continue;
        const [sx, sy] = this.toCanvas(shape.at);
        const reach = Math.max(REACH, (shape.radius_m || 0) * this.view.scale);
        if (Math.hypot(sx - x, sy - y) <= reach) hits.push([reach, shape.id]);
      }
      return hits.sort((one, other) => one[0] - other[0])[0]?.[1] ?? null;
    },
    press(event) {
      if (!this.view || event.button !== 0) return;
      const [x, y] = this.placeOf(event);
      this.$refs.canvas.setPointerCapture(event.pointerId);
      const ruled = measures(event);
      this.pressed = { x, y, from: { ...this.view }, handle: ruled ? undefined : this.handleAt(x, y), ruled, far: false, sent: 0 };
      if (ruled) this.measured = null;
    },
    move(event) {
      const [x, y] = (this.pointer = this.placeOf(event));
      const { pressed } = this;
      if (!this.view) return;
      if (pressed) {
        pressed.far ||= Math.hypot(x - pressed.x, y - pressed.y) > STILL;
        if (pressed.far && pressed.ruled) this.measured = [this.toPlace(pressed.x, pressed.y), this.toPlace(x, y)];
        else if (pressed.far && pressed.handle) this.dragTo(x, y, false);
        else if (pressed.far) {
          this.touched = true;
          this.view.north = pressed.from.north + (y - pressed.y) / this.view.scale;
          this.view.east = pressed.from.east - (x - pressed.x) / this.view.scale;
        }
      }
      const catches = this.handleAt(x, y);
      this.$refs.canvas.style.cursor = catches ? "grab" : pressed?.far ? "grabbing" : "crosshair";
      this.draw();
    },
    dragTo(x, y, done) {
      const { pressed } = this;
      pressed.handle.at = this.toPlace(x, y);
      const now = performance.now();
      if (!done && now - pressed.sent < DRAG_MS) return;
      pressed.sent = now;
      const [north, east] = pressed.handle.at;
      this.$emit("drag", { id: pressed.handle.id, north, east, done });
    },
    release(event) {
      const { pressed } = this;
      if (!pressed) return;
      const [x, y] = this.placeOf(event);
      if (pressed.far && pressed.handle) this.dragTo(x, y, true);
      else if (!pressed.far && !pressed.ruled) {
        const [north, east] = this.toPlace(x, y);
        this.$emit("pick", { id: pressed.handle?.id ?? this.idAt(x, y), north, east });
      }
      if (pressed.far && !pressed.handle && !pressed.ruled) this.look();
      this.pressed = null;
      this.draw();
    },
    // Tells the page what the middle of the plan is, once it was moved.
    look() {
      this.$emit("look", { north: this.view.north, east: this.view.east });
    },
    leave() {
      this.pointer = null;
      this.draw();
    },
    zoom(event) {
      event.preventDefault();
      if (!this.view) return;
      this.touched = true;
      const [x, y] = this.placeOf(event);
      const [north, east] = this.toPlace(x, y);
      const factor = Math.exp(-0.0015 * event.deltaY);
      this.view.scale = Math.min(2000, Math.max(0.01, this.view.scale * factor));
      const [nowNorth, nowEast] = this.toPlace(x, y);
      this.view.north += north - nowNorth;
      this.view.east += east - nowEast;
      clearTimeout(this.looks);
      this.looks = setTimeout(() => this.look(), 150);
      this.draw();
    },
    // -- the ruler --
    forget() {
      this.measured = null;
      this.draw();
    },
    // What was measured, in words: bearing from north, from the first place to the second.
    reading() {
      const [from, to] = this.measured;
      const [north, east] = [to[0] - from[0], to[1] - from[1]];
      const bearing = ((Math.atan2(east, north) * 180) / Math.PI + 360) % 360;
      return [
        `${Math.hypot(north, east).toFixed(2)} m, bearing ${bearing.toFixed(1)}°`,
        `north ${north.toFixed(2)} m, east ${east.toFixed(2)} m`,
      ];
    },
    // -- drawing --
    draw() {
      const prepared = this.$refs.canvas && prepare(this.$refs.canvas);
      if (!prepared) return;
      const { context, width, height } = prepared;
      const shapes = this.all();
      const roles = [...new Set(shapes.filter((shape) => shape.kind !== "handle").map((shape) => shape.role))];
      const entries = legendRows(context, roles.map((role) => [role, legendOf(role)]), width - MARGIN.left - MARGIN.right);
      this.legendHeight = entries.length ? 18 * (entries[entries.length - 1][3] + 1) : 0;
      this.view ??= shapes.length ? this.whole() : null;
      context.textBaseline = "middle";
      context.textAlign = "left";
      context.fillStyle = ink();
      context.fillText([this.now.title, this.now.busy].filter(Boolean).join("  ·  "), MARGIN.left, 13);
      if (!this.view) return this.nothing(context, width, height);
      const box = this.box();
      this.drawAxes(context, box);
      context.save();
      context.beginPath();
      context.rect(box.x, box.y, box.width, box.height);
      context.clip();
      context.globalAlpha = this.now.busy ? 0.4 : 1;
      const labels = new Labels(context, box);
      for (const shape of shapes) this.drawShape(context, shape);
      for (const shape of shapes) if (shape.label) this.writeLabel(labels, shape);
      context.globalAlpha = 1;
      if (this.measured) drawRuler(context, this.measured.map((place) => this.toCanvas(place)), this.reading(), box);
      context.restore();
      for (const [role, label, x, row] of entries)
        legend(context, [[role, label]], box.x + x, box.y + box.height + MARGIN.bottom + 6 + 18 * row);
      this.drawPointer(context, width, height);
    },
    drawAxes(context, box) {
      const [highN, lowE] = this.toPlace(box.x, box.y);
      const [lowN, highE] = this.toPlace(box.x + box.width, box.y + box.height);
      context.lineWidth = 1;
      context.fillStyle = ink();
      context.strokeStyle = gridInk();
      const line = (x1, y1, x2, y2) => {
        context.beginPath();
        context.moveTo(x1, y1);
        context.lineTo(x2, y2);
        context.stroke();
      };
      context.textAlign = "center";
      context.textBaseline = "top";
      for (const [east, text] of ticks(lowE, highE, box.width / 80)) {
        const [x] = this.toCanvas([0, east]);
        line(x, box.y, x, box.y + box.height);
        context.fillText(text, x, box.y + box.height + 5);
      }
      context.fillText("east, m", box.x + box.width / 2, box.y + box.height + 22);
      context.textAlign = "right";
      context.textBaseline = "middle";
      for (const [north, text] of ticks(lowN, highN, box.height / 60)) {
        const [, y] = this.toCanvas([north, 0]);
        line(box.x, y, box.x + box.width, y);
        context.fillText(text, box.x - 6, y);
      }
      context.save();
      context.translate(12, box.y + box.height / 2);
      context.rotate(-Math.PI / 2);
      context.textAlign = "center";
      context.fillText("north, m", 0, 0);
      context.restore();
      context.strokeRect(box.x, box.y, box.width, box.height);
    },
    drawShape(context, shape) {
      const style = styleOf(shape.role);
      context.strokeStyle = context.fillStyle = style.colour;
      context.lineWidth = style.width + (shape.marked ? 1.5 : 0);
      context.setLineDash(shape.dashed ? [3, 4] : style.dash);
      const alpha = context.globalAlpha;
      context.beginPath();
      if (shape.points) {
        shape.points.forEach((point, place) => context[place ? "lineTo" : "moveTo"](...this.toCanvas(point)));
        if (shape.kind === "area") {
          context.closePath();
          context.globalAlpha = alpha * (shape.role === "sector" ? 0.1 : 0.25);
          context.fill();
          context.globalAlpha = alpha;
        }
        if (shape.role !== "sector") context.stroke();
      } else if (shape.kind === "circle" || shape.kind === "ellipse") this.drawRound(context, shape, alpha);
      else this.drawMark(context, shape);
      context.setLineDash([]);
      context.globalAlpha = alpha;
    },
    drawRound(context, shape, alpha) {
      const [x, y] = this.toCanvas(shape.at);
      if (shape.kind === "circle") {
        context.arc(x, y, Math.max(2, shape.radius_m * this.view.scale), 0, 2 * Math.PI);
      } else {
        const [first, second] = shape.semi_m.map((axis) => axis * this.view.scale);
        context.ellipse(x, y, first, second, shape.turn_rad - Math.PI / 2, 0, 2 * Math.PI); // from north, clockwise
        context.globalAlpha = 0.22 * alpha;
        context.fill();
        context.globalAlpha = alpha;
        context.lineWidth = 1;
      }
      context.stroke();
    },
    drawMark(context, shape) {
      const [x, y] = this.toCanvas(shape.at);
      if (shape.kind === "handle") {
        context.rect(x - 5, y - 5, 10, 10);
        context.fill();
        context.lineWidth = shape.marked ? 3 : 1.5;
        context.strokeStyle = shape.marked ? ink() : paper();
      } else if (shape.heading_rad === null) {
        context.moveTo(x - 5, y - 5);
        context.lineTo(x + 5, y + 5);
        context.moveTo(x - 5, y + 5);
        context.lineTo(x + 5, y - 5);
      } else {
        const corner = (turn, away) => [x + away * Math.sin(shape.heading_rad + turn), y - away * Math.cos(shape.heading_rad + turn)];
        [corner(0, 13), corner(2.5, 9), corner(Math.PI, 4), corner(-2.5, 9)].forEach((point, place) =>
          context[place ? "lineTo" : "moveTo"](...point));
        context.closePath();
        context.fill();
      }
      context.stroke();
    },
    writeLabel(labels, shape) {
      const at = shape.at || shape.points[shape.points.length - 1];
      const [x, y] = this.toCanvas(at);
      labels.write(shape.label, x, y, styleOf(shape.role).colour, 8 + (shape.radius_m || 0) * this.view.scale * 0.72);
    },
    drawPointer(context, width, height) {
      if (!this.pointer) return;
      const [north, east] = this.toPlace(...this.pointer);
      context.textAlign = "right";
      context.textBaseline = "middle";
      halo(context, `north ${north.toFixed(1)} m, east ${east.toFixed(1)} m`, width - MARGIN.right - 26, 13);
    },
  },
};
