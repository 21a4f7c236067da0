// What is drawn over a sonar image: range and bearing, circles and their signs, the pinned beam, pointer and ruler.
import { drawRuler } from "ods-charts/ruler.js";
import { niceStep } from "ods-charts/palettes.js";
import { DEG } from "./projection.js";

export const KINDS = {
  detection: { colour: "#ff5a36", label: "detection" },
  right: { colour: "#4fd1a5", label: "right", sign: "✓" },
  false: { colour: "#ff5a36", label: "false", sign: "✕" },
  missed: { colour: "#ffffff", label: "missed", sign: "?", dash: [4, 3] },
  only_a: { colour: "#ff9d2e", label: "only A", sign: "A", dash: [9, 4] },
  only_b: { colour: "#37b6ff", label: "only B", sign: "B", dash: [2, 3], corners: 4 },
  truth: { colour: "#ffffff", label: "true object", dash: [4, 3] },
  track: { colour: "#ff6ad5", label: "track" },
};

function angleStep(rough_deg) {
  return [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 45].find((step) => step >= rough_deg) || 90;
}

export function drawLabel(context, text, x, y, box) {
  context.textAlign = "left";
  const width = context.measureText(text).width;
  const left = Math.min(Math.max(x + 3, box.x + 2), box.x + box.width - width - 3);
  const base = Math.min(Math.max(y - 3, box.y + 12), box.y + box.height - 4);
  context.lineWidth = 3;
  context.strokeStyle = "rgba(0, 0, 0, 0.7)";
  context.strokeText(text, left, base);
  context.fillStyle = "#ffffff";
  context.fillText(text, left, base);
}

// Range arcs and bearing lines; returns their labels, each where its line leaves what is seen.
export function drawGrid(context, projection, zoom) {
  const { left, right, near_m, far_m } = projection.geometry;
  const labels = [];
  context.strokeStyle = "rgba(160, 170, 180, 0.45)";
  context.lineWidth = 1;
  const step_m = niceStep(far_m / 6 / zoom);
  const bearings = Array.from({ length: 91 }, (_, index) => left + ((right - left) * index) / 90);
  const digits = Math.max(0, -Math.floor(Math.log10(step_m)));
  for (let range_m = Math.ceil(near_m / step_m) * step_m; range_m < far_m; range_m += step_m) {
    if (range_m < step_m / 2) continue;
    const end = line(context, projection, bearings.map((bearing) => [range_m, bearing]));
    if (end) labels.push([`${range_m.toFixed(digits)} m`, ...end]);
  }
  const step_deg = angleStep(((right - left) * DEG) / 7 / zoom);
  const ranges = Array.from({ length: 41 }, (_, index) => near_m + ((far_m - near_m) * index) / 40);
  for (let deg = Math.ceil((left * DEG) / step_deg) * step_deg; deg <= right * DEG + 1e-9; deg += step_deg) {
    const end = line(context, projection, ranges.map((range_m) => [range_m, deg / DEG]));
    if (end) labels.push([`${Number(deg.toFixed(1)) + 0}°`, ...end]);
  }
  return labels;
}

function line(context, projection, places) {
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
}

export function drawCircle(context, projection, [range_m, bearing_rad, radius_m, kind]) {
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
  if (sign) drawSign(context, projection, [range_m, bearing_rad, radius_m], sign, colour);
}

// Above the circle, as large at every scale: what is shown by colour is shown by shape, too.
function drawSign(context, projection, [range_m, bearing_rad, radius_m], sign, colour) {
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
}

export function drawPinned(context, projection, bearing) {
  const { near_m, far_m } = projection.geometry;
  context.strokeStyle = "#ffffff";
  context.lineWidth = 1.2;
  context.setLineDash([6, 4]);
  line(context, projection, [[near_m, bearing], [0.5 * (near_m + far_m), bearing], [far_m, bearing]]);
  context.setLineDash([]);
}

// Where it is known: at a place, or anywhere at a range.
export function drawPointer(context, projection, { range, bearing }) {
  if (range === undefined) return;
  for (const [width, colour] of [[3, "rgba(0, 0, 0, 0.7)"], [1.2, "#ffffff"]]) {
    context.lineWidth = width;
    context.strokeStyle = colour;
    if (bearing === undefined) drawArc(context, projection, range);
    else drawCross(context, projection.toCanvas(range, bearing));
  }
}

function drawArc(context, projection, range) {
  const { left, right, near_m, far_m } = projection.geometry;
  if (!(range >= near_m && range <= far_m)) return;
  line(context, projection, Array.from({ length: 91 }, (_, index) => [range, left + ((right - left) * index) / 90]));
}

function drawCross(context, [x, y]) {
  context.beginPath();
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    context.moveTo(x + 4 * dx, y + 4 * dy);
    context.lineTo(x + 12 * dx, y + 12 * dy);
  }
  context.stroke();
}

// A straight way on the bottom, which bends where beams are beside each other.
export function drawMeasured(context, projection, measured) {
  const [from, to] = measured.map(({ range_m, bearing_rad }) => [range_m * Math.cos(bearing_rad), range_m * Math.sin(bearing_rad)]);
  const points = Array.from({ length: 33 }, (_, index) => {
    const [ahead, across] = [0, 1].map((axis) => from[axis] + ((to[axis] - from[axis]) * index) / 32);
    return projection.toCanvas(Math.hypot(ahead, across), Math.atan2(across, ahead));
  });
  drawRuler(context, points, readingOf(measured), projection.box);
}

// What was measured, in words: in the sonar's plane.
export function readingOf([from, to]) {
  const turn = to.bearing_rad - from.bearing_rad;
  const apart = Math.sqrt(Math.max(0, from.range_m ** 2 + to.range_m ** 2 - 2 * from.range_m * to.range_m * Math.cos(turn)));
  const deg = (place) => `${(place.bearing_rad * DEG).toFixed(1)}°`;
  return [
    `${apart.toFixed(2)} m apart`,
    `range ${from.range_m.toFixed(2)} m to ${to.range_m.toFixed(2)} m, bearing ${deg(from)} to ${deg(to)}`,
  ];
}
