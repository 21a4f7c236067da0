// Views without a pointer: one that has the focus by Tab, or V, has a cross that arrows move, and keys that do there what a
// pointer does. Each becomes an event of a pointer, so that a view does the same by either.
const STEP = 4; // pixels; with Shift ten times as many
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const ZOOMS = { "+": -100, "=": -100, "-": 100 };
const WORDS = "arrows move the cross, with Shift faster; Enter clicks, space takes hold and lets go, + and - zoom, 0 shows all";
const OWN = "[role=slider]:not([aria-label=ping]), [role=tab], [role=checkbox], [role=switch], [role=button], [role=listbox],"
  + " [role=menu], .q-slider, .q-item";
const TAKEN = [...Object.keys(ARROWS), " "];

// The page's keys are not those of a slider, a tab or a switch that has the focus.
document.body.addEventListener("keydown", (event) => {
  if (TAKEN.includes(event.key) && event.target.closest?.(OWN)) event.stopPropagation();
});

// What shows where a pointer rests shows where the focus comes by a key, too.
for (const [moves, as] of [["focusin", "mouseenter"], ["focusout", "mouseleave"]])
  document.addEventListener(moves, ({ target }) => {
    if (as === "mouseleave" || target.matches?.(":focus-visible")) target.dispatchEvent(new MouseEvent(as));
  });

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.key.toLowerCase() !== "v") return;
  if (event.target.closest?.("input, textarea, select, .q-dialog, .q-menu")) return;
  const seen = [...document.querySelectorAll("[data-view]")].filter((view) => view.clientWidth);
  const step = event.shiftKey ? seen.length - 1 : 1;
  seen[(seen.indexOf(document.activeElement) + step) % seen.length]?.focus();
});

// Lets a view be worked by keys. `canvas` listeners the pointer.
export function withKeys(view, canvas, name) {
  const cross = crossIn(view);
  let at = null; // the cross, px from the canvas's corner; null: keys are the page's
  let isHeld = false;
  let isPressed = false; // by a real pointer, which gives the focus without the keys
  const capture = canvas.setPointerCapture;
  canvas.setPointerCapture = (id) => id >= 0 && capture.call(canvas, id); // there is no pointer with the id of ours
  view.tabIndex = 0;
  view.dataset.view = "";
  view.setAttribute("role", "application");
  view.setAttribute("aria-label", `${name}: ${WORDS}`);

  const send = (kind, more = {}) => {
    const { left, top } = canvas.getBoundingClientRect();
    const place = { clientX: left + at[0], clientY: top + at[1], pointerId: -1, bubbles: true, cancelable: true, button: 0, ...more };
    const made = kind === "wheel" ? WheelEvent : kind === "dblclick" ? MouseEvent : PointerEvent;
    canvas.dispatchEvent(new made(kind, place));
  };
  const hold = (held) => {
    isHeld = held;
    view.style.outlineStyle = held ? "dashed" : "solid";
    send(held ? "pointerdown" : "pointerup");
  };
  const go = (x, y) => {
    at = [Math.min(Math.max(x, 0), canvas.clientWidth - 1), Math.min(Math.max(y, 0), canvas.clientHeight - 1)];
    Object.assign(cross.style, { display: "block", left: `${at[0]}px`, top: `${at[1]}px` });
    send("pointermove");
  };
  const leave = () => {
    if (at && isHeld) hold(false);
    if (at) send("pointerleave");
    at = null;
    view.style.outline = "";
    cross.style.display = "none";
  };
  const press = (event) => {
    if (!at || event.target !== view || event.ctrlKey || event.metaKey || event.altKey) return;
    const { key } = event;
    const by = STEP * (event.shiftKey ? 10 : 1);
    if (key in ARROWS) go(at[0] + ARROWS[key][0] * by, at[1] + ARROWS[key][1] * by);
    else if (key in ZOOMS) send("wheel", { deltaY: ZOOMS[key] });
    else if (key === "0") send("dblclick");
    else if (key === " ") hold(!isHeld);
    else if (key === "Enter") {
      if (!isHeld) send("pointerdown");
      hold(false);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  };

  view.addEventListener("pointerdown", (event) => {
    if (event.pointerId < 0) return;
    leave();
    isPressed = true;
    isHeld = false;
  });
  view.addEventListener("pointerup", () => (isPressed = false));
  view.addEventListener("focus", () => {
    if (isPressed) return;
    Object.assign(view.style, { outline: "2px solid var(--q-primary)", outlineOffset: "-2px" });
    go(Math.round(canvas.clientWidth / 2), Math.round(canvas.clientHeight / 2));
  });
  view.addEventListener("blur", leave);
  view.addEventListener("keydown", press);
}

function crossIn(view) {
  const cross = document.createElement("div");
  cross.innerHTML = '<i class="material-icons">add</i>';
  Object.assign(cross.style, {
    position: "absolute", display: "none", transform: "translate(-50%, -50%)", fontSize: "28px", lineHeight: "1",
    color: "var(--q-primary)", pointerEvents: "none",
  });
  view.appendChild(cross);
  return cross;
}
