// Over a chart, on a layer of its own: the page's cursor, the pointer of any view with the same axis, a box that is drawn.
import { ink, styleOf } from "./index.js";

const POINTER = [2, 2];
const BOX = { fill: "rgba(47, 129, 247, 0.18)", stroke: "#2f81f7" };

// cursor: an x or null; pointed: {axis: value}; frame: a box, as Places has it. Returns zrender's elements.
export function overlay({ Line, Rect }, places, { cursor, pointed, frame }) {
  const { about, boxes, ends, laid } = places;
  const marks = [];
  const line = (x1, y1, x2, y2, stroke, lineDash) => marks.push(
    new Line({ shape: { x1, y1, x2, y2 }, style: { stroke, lineWidth: 1, lineDash }, silent: true, zlevel: 1, subPixelOptimize: true }));
  const isIn = (value, [low, high]) => value >= low && value <= high; // undefined is not
  const upright = (value, stroke, dash) => {
    if (!isIn(value, ends.x)) return;
    for (const box of boxes) line(places.toX(box, value), box.y, places.toX(box, value), box.y + box.height, stroke, dash);
  };
  if (cursor !== null) upright(cursor, styleOf("approach").colour, null);
  upright(pointed[about.x.cursor], ink(), POINTER);
  about.panels.forEach(({ y }, place) => {
    const [value, box] = [pointed[y.cursor], laid.panels[place]];
    if (!isIn(value, ends.y[place])) return;
    line(box.x, places.toY(place, value), box.x + box.width, places.toY(place, value), ink(), POINTER);
  });
  if (frame) {
    const [[x1, x2], [y1, y2]] = frame;
    marks.push(new Rect({ shape: { x: x1, y: y1, width: x2 - x1, height: y2 - y1 }, style: BOX, silent: true, zlevel: 1 }));
  }
  return marks;
}
