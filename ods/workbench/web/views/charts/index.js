// What the views of the page share: colours by role, ticks, sharp canvases, labels that keep apart.
import { withKeys } from "./keys.js";

// Okabe and Ito's colours, which colour-blind eyes distinguish; [on dark, on light].
const ROLES = {
  vehicle: { colours: ["#e6edf3", "#1f2328"], label: "vehicle", width: 2 },
  truth: { colours: ["#ff8c42", "#c24a00"], label: "true object", dash: [5, 4] },
  tentative: { colours: ["#d98cba", "#a5518a"], label: "tentative" },
  active: { colours: ["#1fc79a", "#00795a"], label: "active", width: 2 },
  stand_by: { colours: ["#f0b429", "#a86a00"], label: "stand-by", width: 2 },
  hibernated: { colours: ["#56b4e9", "#0072b2"], label: "hibernated", width: 2 },
  terminated: { colours: ["#8b949e", "#6e7781"], label: "terminated" },
  uncertainty: { colours: ["#1fc79a", "#00795a"], label: "two standard deviations" },
  prediction: { colours: ["#b6a4ff", "#6a4fc9"], label: "predicted", dash: [2, 3] },
  approach: { colours: ["#ff6b6b", "#c1121f"], label: "closest approach" },
  goal: { colours: ["#ff6b6b", "#c1121f"], label: "goal" },
  sector: { colours: ["#56b4e9", "#0072b2"], label: "sonar's sector", area: true },
  object: { colours: ["#f0b429", "#a86a00"], label: "object", width: 2 },
  path: { colours: ["#b6a4ff", "#6a4fc9"], label: "path" },
  veto: { colours: ["#c9d1d9", "#57606a"], dash: [2, 4], label: "operator's veto" },
  first: { colours: ["#56b4e9", "#0072b2"] },
  second: { colours: ["#f0b429", "#a86a00"] },
  third: { colours: ["#1fc79a", "#00795a"] },
  fourth: { colours: ["#d98cba", "#a5518a"] },
  quiet: { colours: ["#8b949e", "#6e7781"] },
};

let isForPrint = false;

export function isDark() {
  return !isForPrint && document.body.classList.contains("body--dark");
}

// Calls something in the colours for paper.
export function onPaper(draw) {
  isForPrint = true;
  try {
    return draw();
  } finally {
    isForPrint = false;
  }
}

export const ink = () => (isDark() ? "#c9d1d9" : "#1f2328");
export const paper = () => (isDark() ? "#0d1117" : "#ffffff");
export const gridInk = () => (isDark() ? "rgba(201,209,217,0.14)" : "rgba(31,35,40,0.12)");

export function styleOf(role) {
  const { colours, ...style } = ROLES[role] || ROLES.quiet;
  return { width: 1.5, dash: [], label: role.replace("_", "-"), ...style, colour: colours[isDark() ? 0 : 1] };
}

const STATES = ["tentative", "active", "stand_by", "hibernated", "terminated"];

// What a role is called beside others: tracks are distinguished from true objects.
export const legendOf = (role) => (STATES.includes(role) ? `track: ${styleOf(role).label}` : styleOf(role).label);

// Clears a canvas of the size of its box, in CSS pixels; null while it is not shown.
export function prepare(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (!width || !height) return null;
  const ratio = window.devicePixelRatio || 1;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  context.lineJoin = "round";
  return { context, width, height };
}

export function ticks(low, high, most) {
  const rough = (high - low) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((each) => each * power >= rough * (1 - 1e-9));
  const found = [];
  for (let value = Math.ceil(low / step - 1e-9) * step; value <= high + 1e-9 * step; value += step) found.push(value);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return found.map((value) => [value, (Math.abs(value) < step / 2 ? 0 : value).toFixed(digits)]);
}

export function halo(context, text, x, y, colour = ink()) {
  context.save();
  context.setLineDash([]);
  context.lineWidth = 3;
  context.strokeStyle = paper();
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
  context.restore();
}

// Writes labels beside their points where no other one is, inside a box.
export class Labels {
  constructor(context, box) {
    Object.assign(this, { context, box, taken: [] });
  }
  write(text, x, y, colour, gap = 8) {
    const { context } = this;
    const { x: left, y: top, width, height } = this.box;
    if (x < left || x > left + width || y < top || y > top + height) return;
    context.textAlign = "left";
    context.textBaseline = "middle";
    const length = context.measureText(text).width;
    const places = [[gap, 0], [gap, -15], [gap, 15], [-gap - length, 0], [-gap - length, -15], [-gap - length, 15]];
    for (const far of [30, 45]) places.push([gap, -far], [gap, far]);
    for (const [dx, dy] of places) {
      // above and below the point a long one may be moved along
      const start = dy ? Math.max(left, Math.min(x + dx, left + width - length)) : x + dx;
      const box = [start, y + dy - 7, start + length, y + dy + 7];
      const outside = box[0] < left || box[2] > left + width || box[1] < top || box[3] > top + height;
      if (outside || this.taken.some((other) => meet(box, other))) continue;
      this.taken.push(box);
      halo(context, text, start, y + dy, colour);
      return;
    }
  }
}

function meet(one, other) {
  return one[0] < other[2] && one[2] > other[0] && one[1] < other[3] && one[3] > other[1];
}

// Where the entries of a legend stand below a chart of that width: [[role, label, x, row], ...].
export function legendRows(context, entries, width, gap = 16) {
  let [x, row] = [0, 0];
  return entries.map(([role, label]) => {
    const wide = 28 + context.measureText(label).width + gap;
    if (x && x + wide > width) [x, row] = [0, row + 1];
    x += wide;
    return [role, label, x - wide, row];
  });
}

// Lines of a legend: [[role, label], ...] at a place.
export function legend(context, entries, x, y, perLine = 18) {
  context.textAlign = "left";
  context.textBaseline = "middle";
  entries.forEach(([role, label], place) => {
    const style = styleOf(role);
    const middle = y + place * perLine;
    context.strokeStyle = context.fillStyle = style.colour;
    context.lineWidth = Math.max(2, style.width);
    context.setLineDash(style.dash);
    context.beginPath();
    context.moveTo(x, middle);
    context.lineTo(x + 22, middle);
    if (style.area) {
      context.globalAlpha = 0.3;
      context.fillRect(x, middle - 5, 22, 10);
      context.globalAlpha = 1;
    } else context.stroke();
    context.setLineDash([]);
    halo(context, label || style.label, x + 28, middle);
  });
}

// Calls back when the page turns dark or light, and when the element's size changes; returns what ends that.
export function watch(element, changed) {
  let wasDark = isDark();
  const theme = new MutationObserver(() => {
    if (wasDark === isDark()) return; // each key changes some class
    wasDark = isDark();
    changed();
  });
  theme.observe(document.body, { attributes: true, attributeFilter: ["class"] });
  const size = new ResizeObserver(changed);
  size.observe(element);
  return () => {
    theme.disconnect();
    size.disconnect();
  };
}

// Puts a small button into the lower right corner of a view, so far from its right edge.
export function cornerButton(element, icon, title, right, clicked) {
  const button = document.createElement("button");
  button.innerHTML = `<i class="material-icons">${icon}</i>`;
  button.title = button.ariaLabel = title;
  Object.assign(button.style, {
    position: "absolute", bottom: "2px", right: `${right}px`, padding: "1px", border: "0", background: "none",
    color: "inherit", fontSize: "16px", height: "18px", lineHeight: "1", cursor: "pointer", opacity: 0.5, zIndex: 1,
  });
  button.addEventListener("click", () => {
    clicked();
    button.blur();
  });
  element.appendChild(button);
}

function download(title, ending, href) {
  const name = `${title}`.replace(/[^\w.]+/g, "-").replace(/^-|-$/g, "") || "view";
  Object.assign(document.createElement("a"), { download: `${name}.${ending}`, href }).click();
}

// Sends a text to the browser's downloads.
export function saveAs(title, ending, text, type) {
  const address = URL.createObjectURL(new Blob([text], { type }));
  download(title, ending, address);
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

// Puts a button into the corner of a view that sends its canvases as one picture to the browser's downloads; `title` shows
// what it is called.
export function withPicture(element, title) {
  const save = () => download(title(), "png", pictureOf(element).toDataURL());
  cornerButton(element, "photo_camera", "download this view as a picture", 6, save);
}

function pictureOf(element) {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [element.clientWidth * ratio, element.clientHeight * ratio];
  const whole = Object.assign(document.createElement("canvas"), { width, height });
  const context = whole.getContext("2d");
  context.fillStyle = paper();
  context.fillRect(0, 0, width, height);
  context.imageSmoothingEnabled = false;
  for (const canvas of element.querySelectorAll("canvas")) {
    const place = [canvas.offsetLeft, canvas.offsetTop, canvas.clientWidth, canvas.clientHeight];
    if (canvas.width && canvas.height) context.drawImage(canvas, ...place.map((pixels) => pixels * ratio));
  }
  return whole;
}

// A component that draws on one canvas: mix this in, have `draw()`, and say what the canvas listens to in `listeners`.
export const onCanvas = {
  mounted() {
    this.unwatch = watch(this.$el, () => this.draw());
    withPicture(this.$el, () => this.now.title ?? this.$options.name ?? "");
    withKeys(this.$el, this.$refs.canvas, this.now.title || "a chart");
    for (const [name, listener] of Object.entries(this.listeners()))
      this.$refs.canvas.addEventListener(name, listener, { passive: name !== "wheel" });
    this.draw();
  },
  beforeUnmount() {
    this.unwatch();
  },
  methods: {
    placeOf(event) {
      const bounds = this.$refs.canvas.getBoundingClientRect();
      return [event.clientX - bounds.left, event.clientY - bounds.top];
    },
    // What of a canvas is drawn in: all but the margin.
    inside(margin) {
      const { clientWidth, clientHeight } = this.$refs.canvas;
      const width = Math.max(20, clientWidth - margin.left - margin.right);
      return { x: margin.left, y: margin.top, width, height: Math.max(20, clientHeight - margin.top - margin.bottom) };
    },
    nothing(context, width, height) {
      context.textAlign = "center";
      context.fillText(this.now.busy || "nothing to show yet", width / 2, height / 2);
    },
  },
};

export const CANVAS = `
    <div style="position: relative; width: 100%; height: 100%; min-height: 120px; overflow: hidden">
      <canvas ref="canvas" style="position: absolute; inset: 0; width: 100%; height: 100%; touch-action: none"></canvas>
    </div>`;
