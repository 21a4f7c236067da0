// The pointer over a sonar image: what it is at, and what a click, a drag and the wheel do.
import { pointAt } from "ods-charts/cursors.js";
import { measures } from "ods-charts/ruler.js";
import { beamAt } from "./projection.js";

const PICK_MS = 300; // zoomed in, a second click may follow, which shows the whole image

// Methods of a component that has frame, zoom, draws, box(), project(), drawOver(), redraw(); `measure` gets the places that
// the ruler lies between, or null.
export const pointing = (measure) => ({
  methods: {
    spotAt(range_m, bearing_rad) {
      if (!this.frame) return null;
      const { geometry, data, scale_db, pool, samples } = this.frame;
      const cell = Math.floor((range_m - geometry.first_m) / geometry.cell_m);
      const beam = cell >= 0 && cell < geometry.cells ? beamAt(geometry.borders, bearing_rad) : -1;
      if (beam < 0) return null;
      const value = data[beam * geometry.cells + cell];
      const sample = Math.min(samples - 1, Math.floor((range_m - geometry.first_m) / (geometry.cell_m / pool)));
      return { range_m, bearing_rad, beam, sample, level_db: scale_db[0] + ((scale_db[1] - scale_db[0]) * value) / 255 };
    },
    // Beams and samples between two places of the canvas; what lies beside the image counts as its edge.
    between(from, to) {
      const spots = [from, to].map(({ x, y }) => this.nearest(this.rawPlace(x, y)));
      const ends = (name) => spots.map((spot) => spot[name]).sort((one, other) => one - other);
      return { beams: ends("beam"), samples: ends("sample") };
    },
    nearest({ range_m, bearing_rad }) {
      const { first_m, far_m, left, right } = this.frame.geometry;
      const inside = (value, low, high) => Math.min(Math.max(value, low + 1e-6), high - 1e-6);
      return this.spotAt(inside(range_m, first_m, far_m), inside(bearing_rad, left, right));
    },
    placeOf(event) {
      if (!this.frame) return null;
      const { range_m, bearing_rad } = this.rawPlace(event.offsetX, event.offsetY);
      return this.spotAt(range_m, bearing_rad);
    },
    rawPlace(x, y) {
      const [range_m, bearing_rad] = this.project().projection.toPlace(x, y);
      return { range_m, bearing_rad };
    },
    listeners() {
      return {
        pointermove: (event) => this.moved(event),
        pointerdown: (event) => this.pressed(event),
        pointerup: (event) => this.released(event),
        pointerleave: () => pointAt({}),
        wheel: (event) => this.zoomed(event),
        dblclick: () => this.showAll(),
      };
    },
    moved(event) {
      if (this.drag) {
        this.drag.moved = this.drag.moved || Math.hypot(event.offsetX - this.drag.x, event.offsetY - this.drag.y) > 4;
        if (this.drag.moved && this.drag.ruled) {
          measure([this.rawPlace(this.drag.x, this.drag.y), this.rawPlace(event.offsetX, event.offsetY)]);
        } else if (this.drag.moved && this.drag.draws) {
          this.drag.box = this.between(this.drag, { x: event.offsetX, y: event.offsetY });
          return this.drawOver();
        } else if (this.drag.moved)
          return this.setZoom({
            factor: this.zoom.factor,
            x: this.drag.zoom.x - (event.offsetX - this.drag.x), y: this.drag.zoom.y + (event.offsetY - this.drag.y),
          });
      }
      const spot = this.placeOf(event);
      pointAt(spot ? { range: spot.range_m, bearing: spot.bearing_rad } : {});
      if (spot) this.$emit("hover", spot);
    },
    pressed(event) {
      event.target.setPointerCapture(event.pointerId);
      const ruled = measures(event) && this.frame !== null;
      const draws = this.draws && event.button === 0 && !ruled && this.frame !== null;
      this.drag = { x: event.offsetX, y: event.offsetY, zoom: this.zoom, moved: false, ruled, draws };
      if (ruled) measure(null);
    },
    released(event) {
      const wasClick = this.drag && !this.drag.moved && !this.drag.ruled;
      const drawn = this.drag?.box;
      this.drag = null;
      if (drawn) return this.$emit("drawn", drawn);
      const spot = wasClick && event.button === 0 ? this.placeOf(event) : null;
      if (!spot) return;
      if (this.zoom.factor === 1) return this.$emit("pick", spot);
      clearTimeout(this.picking); // zoomed in, a second click may follow, which shows the whole image
      this.picking = setTimeout(() => this.$emit("pick", spot), PICK_MS);
    },
    zoomed(event) {
      event.preventDefault();
      if (!this.frame) return;
      const factor = Math.min(64, Math.max(1, this.zoom.factor * 1.25 ** (event.deltaY < 0 ? 1 : -1)));
      const change = factor / this.zoom.factor;
      const box = this.box();
      const x = event.offsetX - box.x - 0.5 * box.width;
      const y = 0.5 * box.height - (event.offsetY - box.y);
      this.setZoom(
        factor === 1 ? { factor, x: 0, y: 0 } : { factor, x: (this.zoom.x + x) * change - x, y: (this.zoom.y + y) * change - y },
      );
    },
    showAll() {
      clearTimeout(this.picking);
      this.setZoom({ factor: 1, x: 0, y: 0 });
    },
    setZoom(zoom) {
      this.zoom = zoom;
      if (this.zooming) return;
      this.zooming = true;
      requestAnimationFrame(() => {
        this.zooming = false;
        this.redraw();
      });
    },
  },
});
