// A bar from the first ping to the last. While it is dragged its thumb follows the pointer at once and the newest place is
// sent every STEP_MS, beside which the page does nothing: at each value of NiceGUI's own slider it would go through all
// elements of the page, and few pictures would be drawn.
const STEP_MS = 33;
const LINE = "position: absolute; left: 0; top: 7px; height: 4px; border-radius: 2px";

export default {
  template: `
    <div role="slider" aria-label="ping" aria-valuemin="0" tabindex="0"
         style="position: relative; width: 100%; height: 18px; cursor: pointer; touch-action: none">
      <div style="${LINE}; right: 0; background: currentColor; opacity: 0.26"></div>
      <div ref="done" style="${LINE}; background: var(--q-primary)"></div>
      <div ref="thumb" style="position: absolute; top: 3px; width: 12px; height: 12px; margin-left: -6px; border-radius: 50%;
                              background: var(--q-primary)"></div>
    </div>`,
  props: { place: Number, last: Number },
  mounted() {
    this.now = { place: this.place, last: this.last }; // as the page has set them since, or the hand
    this.sent = null; // the last place, and when
    this.sentAt = -STEP_MS;
    this.timer = null;
    this.isHeld = false;
    const listeners = { pointerdown: this.press, pointermove: this.move, pointerup: this.release, pointercancel: this.release,
      keydown: this.key };
    for (const [name, listener] of Object.entries(listeners)) this.$el.addEventListener(name, listener);
    this.draw();
  },
  methods: {
    set(place, last) {
      this.now = { place: this.isHeld ? this.now.place : place, last };
      this.draw();
    },
    draw() {
      const { place, last } = this.now;
      const at = `${(100 * Math.min(place, last)) / last}%`;
      this.$refs.done.style.width = at;
      this.$refs.thumb.style.left = at;
      this.$el.setAttribute("aria-valuemax", last);
      this.$el.setAttribute("aria-valuenow", place);
    },
    // The first and the last ping; arrows are the page's.
    key(event) {
      const { key } = event;
      if (key !== "Home" && key !== "End") return;
      event.preventDefault();
      this.now.place = key === "Home" ? 0 : this.now.last;
      this.draw();
      this.$emit("scrub", { place: this.now.place, held: false });
    },
    press(event) {
      if (event.button !== 0) return;
      this.$el.setPointerCapture(event.pointerId);
      this.isHeld = true;
      this.bounds = this.$el.getBoundingClientRect();
      this.move(event);
    },
    move(event) {
      if (!this.isHeld) return;
      const share = (event.clientX - this.bounds.left) / this.bounds.width;
      this.now.place = Math.round(Math.min(1, Math.max(0, share)) * this.now.last);
      this.draw();
      this.timer ??= setTimeout(this.send, Math.max(0, this.sentAt + STEP_MS - performance.now()));
    },
    send() {
      this.timer = null;
      if (this.sent === this.now.place) return;
      this.sent = this.now.place;
      this.sentAt = performance.now();
      this.$emit("scrub", { place: this.now.place, held: true });
    },
    release() {
      if (!this.isHeld) return;
      clearTimeout(this.timer);
      this.isHeld = false;
      this.sent = this.timer = null;
      this.$emit("scrub", { place: this.now.place, held: false });
    },
  },
};
