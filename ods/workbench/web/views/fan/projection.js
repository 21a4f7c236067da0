// Where the cells of a sonar image lie, and where its places are on a canvas: as a fan, or beams beside each other.

export const DEG = 180 / Math.PI;
const TURN_GAIN = 1.5; // a narrow fan lies on its side where it is larger by this at least

function bordersOf(bearing) {
  const last = bearing.length - 1;
  if (!last) return [bearing[0] - 0.01, bearing[0] + 0.01];
  const borders = [1.5 * bearing[0] - 0.5 * bearing[1]];
  for (let beam = 0; beam < last; beam++) borders.push(0.5 * (bearing[beam] + bearing[beam + 1]));
  borders.push(1.5 * bearing[last] - 0.5 * bearing[last - 1]);
  return borders;
}

export function geometryOf(frame) {
  const borders = bordersOf(frame.bearing_rad);
  const cell_m = frame.dr_m * frame.pool;
  const near_m = Math.max(0, frame.range0_m - 0.5 * frame.dr_m);
  return {
    beams: frame.beams, cells: frame.cells, cell_m, borders, near_m,
    first_m: frame.range0_m - 0.5 * frame.dr_m, // where the first cell begins
    far_m: frame.range0_m + (frame.samples - 0.5) * frame.dr_m,
    left: borders[0], right: borders[frame.beams],
  };
}

export function beamAt(borders, bearing) {
  let low = 0;
  let high = borders.length - 1;
  if (!(bearing >= borders[low] && bearing < borders[high])) return -1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (bearing >= borders[middle]) low = middle;
    else high = middle;
  }
  return low;
}

// Of a fan seen with its axis to the right instead of up; starboard is below then.
const turned = ({ x0, x1, y0, y1 }) => ({ x0: y0, x1: y1, y0: -x1, y1: -x0 });

// Pixels that a metre has where all of an extent is to be seen.
const fitOf = ({ x0, x1, y0, y1 }, box) => Math.min(box.width / (x1 - x0), box.height / (y1 - y0));

// Where places of the image are on the canvas: `box` is the part of the canvas that the image may fill.
export class Projection {
  constructor(geometry, presentation, box, zoom) {
    Object.assign(this, { geometry, box });
    this.isFan = presentation === "fan";
    const { left, right, far_m, near_m } = geometry;
    let extent = { x0: left * DEG, x1: right * DEG, y0: near_m, y1: far_m };
    if (this.isFan) {
      const arc = Array.from({ length: 181 }, (_, index) => left + ((right - left) * index) / 180);
      const across = arc.map((bearing) => far_m * Math.sin(bearing));
      const ahead = arc.map((bearing) => far_m * Math.cos(bearing));
      extent = { x0: Math.min(0, ...across), x1: Math.max(0, ...across), y0: Math.min(0, ...ahead), y1: Math.max(0, ...ahead) };
    }
    if (this.isFan && fitOf(turned(extent), box) > TURN_GAIN * fitOf(extent, box)) {
      this.isTurned = true;
      extent = turned(extent);
    }
    this.scaleX = box.width / (extent.x1 - extent.x0);
    this.scaleY = box.height / (extent.y1 - extent.y0);
    if (this.isFan) this.scaleX = this.scaleY = 0.97 * fitOf(extent, box);
    this.scaleX *= zoom.factor;
    this.scaleY *= zoom.factor;
    this.x = 0.5 * (extent.x0 + extent.x1) + zoom.x / this.scaleX;
    this.y = 0.5 * (extent.y0 + extent.y1) + zoom.y / this.scaleY;
  }
  toCanvas(range_m, bearing) {
    const across = this.isFan ? range_m * Math.sin(bearing) : bearing * DEG;
    const ahead = this.isFan ? range_m * Math.cos(bearing) : range_m;
    const [x, y] = this.isTurned ? [ahead, -across] : [across, ahead];
    const { box } = this;
    return [box.x + 0.5 * box.width + (x - this.x) * this.scaleX, box.y + 0.5 * box.height - (y - this.y) * this.scaleY];
  }
  toPlace(canvasX, canvasY) {
    const { box } = this;
    const x = this.x + (canvasX - box.x - 0.5 * box.width) / this.scaleX;
    const y = this.y - (canvasY - box.y - 0.5 * box.height) / this.scaleY;
    if (!this.isFan) return [y, x / DEG];
    return [Math.hypot(x, y), this.isTurned ? Math.atan2(-y, x) : Math.atan2(x, y)];
  }
  // Cell under each pixel of the box; `beams * cells` where there is none.
  table() {
    const { beams, cells, borders, first_m, cell_m } = this.geometry;
    const { width, height } = this.box;
    const table = new Int32Array(width * height);
    for (let row = 0, at = 0; row < height; row++) {
      for (let column = 0; column < width; column++, at++) {
        const [range_m, bearing] = this.toPlace(this.box.x + column + 0.5, this.box.y + row + 0.5);
        const cell = Math.floor((range_m - first_m) / cell_m);
        const beam = cell >= 0 && cell < cells ? beamAt(borders, bearing) : -1;
        table[at] = beam < 0 ? beams * cells : beam * cells + cell;
      }
    }
    return table;
  }
  // Near the apex of a fan beams are finer than pixels: [cell, pixel, ...] of all cells there, so that none is lost.
  crowded() {
    const { beams, cells, borders, first_m, cell_m } = this.geometry;
    const { width, height } = this.box;
    const finest = Math.min(...borders.slice(1).map((border, beam) => border - borders[beam]));
    const pixel = this.isFan ? 1 / this.scaleX : 0;
    const until = this.isFan ? Math.min(cells, Math.ceil((pixel / finest - first_m) / cell_m)) : 0;
    const pairs = [];
    const wide = !this.isFan && (finest * DEG * this.scaleX < 1); // more beams than columns
    for (let beam = 0; beam < beams; beam++) {
      for (let cell = 0; cell < (wide ? cells : until); cell++) {
        const middle = 0.5 * (borders[beam] + borders[beam + 1]);
        const [x, y] = this.toCanvas(first_m + (cell + 0.5) * cell_m, middle);
        const column = Math.floor(x - this.box.x);
        const row = Math.floor(y - this.box.y);
        if (column >= 0 && column < width && row >= 0 && row < height) pairs.push(beam * cells + cell, row * width + column);
      }
    }
    return Int32Array.from(pairs);
  }
}
