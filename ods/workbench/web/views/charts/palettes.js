// What images share: palettes that are perceptually even, and the scale of colours beside an image.
import { ink } from "./index.js";

const PALETTES = {
  viridis:
    "440154470d60481a6c482576472f7d4439834144873d4e8a39568c355f8d31688e2d718e2a788e27808e23888e21918c1f988b1fa08822a884" +
    "2ab07f35b77942be7154c56867cc5c7ad1518ed645a5db36bddf26d2e21be7e419fde725",
  cividis:
    "00224e00285b002e6c0c34701e3a6f2a3f6d35456c3f4c6c47516c4f576c575d6d5f636f6669706d6f727575757d7c788482798c8878948e77" +
    "9d9576a59c74ada272b7a96ec0b16ac8b866d1bf61dbc75ae5cf52eed649f7de3efee838",
  gray: "000000ffffff",
};

export function niceStep(rough, steps = [1, 2, 5, 10]) {
  const power = 10 ** Math.floor(Math.log10(rough));
  return steps.find((step) => step * power >= rough * (1 - 1e-9)) * power;
}

export function paletteOf(name) {
  const anchors = PALETTES[name].match(/../g).map((digits) => parseInt(digits, 16));
  const last = anchors.length / 3 - 1;
  return (share) => {
    const at = Math.min(1, Math.max(0, share)) * last;
    const below = Math.min(last - 1, Math.floor(at));
    const mix = (channel) => {
      const low = anchors[3 * below + channel];
      return Math.round(low + (anchors[3 * below + 3 + channel] - low) * (at - below));
    };
    return [mix(0), mix(1), mix(2)];
  };
}

export const pack = ([red, green, blue]) => ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;

// Draws the scale to the right of an image's box; returns where on the canvas a level is, dB to y.
export function drawScale(context, box, [low, high], palette) {
  const colour = paletteOf(palette);
  const left = box.x + box.width + 10;
  for (let row = 0; row < box.height; row++) {
    context.fillStyle = `rgb(${colour(1 - row / (box.height - 1)).join(",")})`;
    context.fillRect(left, box.y + row, 10, 1.5);
  }
  const step = niceStep((high - low) / 5);
  const heightOf = (level) => box.y + box.height * (1 - (level - low) / (high - low));
  context.fillStyle = ink();
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  for (let level = Math.ceil(low / step) * step; level <= high; level += step)
    context.fillText(`${Number(level.toFixed(1)) + 0} dB`, left + 14, heightOf(level) + 4, 50);
  return heightOf;
}
