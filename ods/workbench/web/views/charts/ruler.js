// A ruler for images and plans: a drag from one place to another while it is on, or with Shift, measures.
import { halo, ink } from "./index.js";

const TIP = "measure: drag from one place to another (M, or Shift and drag; Esc ends it)";
const users = new Set();
let isOn = false;

export const measures = (event) => event.button === 0 && (isOn || event.shiftKey);

function turn(on) {
  isOn = on;
  for (const user of users) user(on);
}

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.("input, textarea, select")) return;
  if (event.key === "m" || event.key === "M") turn(!isOn);
  else if (event.key === "Escape") turn(false);
});

// Puts the ruler's button into the corner of a view; `forget` is called when the ruler is put away. Returns what takes
// it out again.
export function withRuler(element, forget) {
  const button = document.createElement("button");
  button.innerHTML = '<i class="material-icons">straighten</i>';
  button.title = button.ariaLabel = TIP;
  Object.assign(button.style, {
    position: "absolute", top: "2px", right: "6px", padding: "1px", border: "0", borderRadius: "3px", fontSize: "18px",
    height: "20px", lineHeight: "1", cursor: "pointer",
  });
  const show = (on) => {
    Object.assign(button.style, on ? { background: "#2f81f7", color: "#ffffff", opacity: 1 }
      : { background: "none", color: "inherit", opacity: 0.6 });
    if (!on) forget();
  };
  button.addEventListener("click", () => {
    turn(!isOn);
    button.blur();
  });
  element.appendChild(button);
  users.add(show);
  show(isOn);
  return () => users.delete(show);
}

// Draws what was measured through `points` of the canvas, with its words beside the middle, inside `box`.
export function drawRuler(context, points, words, box) {
  context.setLineDash([]);
  for (const [width, colour] of [[4, "rgba(0, 0, 0, 0.7)"], [1.6, "#ffd33d"]]) {
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.beginPath();
    for (const point of points) context.lineTo(...point);
    for (const [x, y] of [points[0], points[points.length - 1]]) {
      context.moveTo(x + 4, y);
      context.arc(x, y, 4, 0, 2 * Math.PI);
    }
    context.stroke();
  }
  const [x, y] = points[points.length >> 1];
  const length = Math.max(...words.map((line) => context.measureText(line).width));
  const left = Math.min(Math.max(x + 10, box.x + 4), box.x + box.width - length - 4);
  const top = Math.min(Math.max(y - 14, box.y + 10), box.y + box.height - 16 * words.length);
  context.textAlign = "left";
  context.textBaseline = "middle";
  words.forEach((line, row) => halo(context, line, left, top + 16 * row, ink()));
}
