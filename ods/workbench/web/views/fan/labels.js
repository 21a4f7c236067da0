// Labels that a person drew over a sonar image: boxes of beams and samples, or what is round in them.
import { halo } from "ods-charts";

const COLOUR = "#ffd33d";
const STEPS = 24; // of an edge that is bent in a fan

// Lines of a box, [first beam, last beam, first sample, last sample, shape], on the canvas.
function outline(projection, frame, [first, last, begin, end, shape]) {
  const { borders, first_m } = projection.geometry;
  const [left, right] = [borders[first], borders[last + 1]];
  const [near_m, far_m] = [first_m + begin * frame.dr_m, first_m + (end + 1) * frame.dr_m];
  const at = (across, along) =>
    projection.toCanvas(near_m + (far_m - near_m) * along, left + (right - left) * across);
  if (shape === "ellipse")
    return Array.from({ length: 4 * STEPS + 1 }, (_, index) => {
      const angle = (index / (2 * STEPS)) * Math.PI;
      return at(0.5 + 0.5 * Math.cos(angle), 0.5 + 0.5 * Math.sin(angle));
    });
  const edge = Array.from({ length: STEPS + 1 }, (_, index) => index / STEPS);
  return [...edge.map((part) => at(part, 0)), ...edge.map((part) => at(1 - part, 1)), at(0, 0)];
}

export function drawBox(context, projection, frame, box) {
  const points = outline(projection, frame, box);
  context.setLineDash([]);
  for (const [width, colour] of [[3.5, "rgba(0, 0, 0, 0.75)"], [1.5, COLOUR]]) {
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.beginPath();
    for (const point of points) context.lineTo(...point);
    context.stroke();
  }
  return points;
}

// Each with its number among those of the image, and its text.
export function drawLabels(context, projection, frame) {
  (frame.labels || []).forEach((label, index) => {
    const points = drawBox(context, projection, frame, label);
    const [x, y] = points.reduce((best, point) => (point[1] < best[1] ? point : best));
    context.textAlign = "left";
    context.textBaseline = "alphabetic";
    halo(context, [index + 1, label[5]].filter(Boolean).join(" "), x + 4, y - 4, COLOUR);
  });
}
