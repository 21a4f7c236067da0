// The pixels of a sonar image: each has the colour of the cell under it.
import { pack, paletteOf } from "ods-charts/palettes.js";

const DIM = 0.35; // of what attention skips

// Colours by cell value, dimmed ones 256 further on, and nothing at 512.
function coloursOf(palette, scale, shown) {
  const colour = paletteOf(palette);
  const table = new Uint32Array(513);
  for (let value = 0; value < 256; value++) {
    const level = scale[0] + ((scale[1] - scale[0]) * value) / 255;
    const rgb = colour((level - shown[0]) / (shown[1] - shown[0]));
    table[value] = pack(rgb);
    table[256 + value] = pack(rgb.map((part) => Math.round(part * DIM)));
  }
  return table; // 512: transparent
}

// Each cell's colour, and one more, that of no cell; `attention` dims those that were skipped.
function cellsOf({ data, attended }, attention) {
  const cells = new Uint16Array(data.length + 1);
  cells.set(data);
  cells[data.length] = 512;
  if (attention && attended) for (let cell = 0; cell < data.length; cell++) if (!attended[cell]) cells[cell] += 256;
  return cells;
}

// Fills pixels, as 32-bit colours. tables: of Projection; limits: of the colour scale, dB.
export function fill(out, frame, { table, crowded }, { palette, limits, attention }) {
  const colours = coloursOf(palette, frame.scale_db, limits);
  const cells = cellsOf(frame, attention);
  if (!crowded.length) {
    for (let pixel = 0; pixel < table.length; pixel++) out[pixel] = colours[cells[table[pixel]]];
    return;
  }
  const values = new Uint16Array(table.length);
  for (let pixel = 0; pixel < table.length; pixel++) values[pixel] = cells[table[pixel]];
  for (let pair = 0; pair < crowded.length; pair += 2) {
    const value = cells[crowded[pair]];
    const pixel = crowded[pair + 1];
    if (values[pixel] === 512 || (value & 255) > (values[pixel] & 255)) values[pixel] = value;
  }
  for (let pixel = 0; pixel < table.length; pixel++) out[pixel] = colours[values[pixel]];
}
