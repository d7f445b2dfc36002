// What a picture shows, in numbers: shares of coloured pixels, distinct colours, how much two
// pictures differ. Pictures are PNGs.
import { decodePng } from './png.mjs';

/**
 * `colourful`: the share of pixels with a chroma (most minus least of red, green, blue)
 * above 60; `colours`: how many different ones, at 16 steps a channel, cover 0.05 % each;
 * `still`: the share of the picture that is its commonest colour.
 */
export function statistics(png) {
  const { data, width, height } = decodePng(png);
  const counts = new Uint32Array(1 << 12);
  let colourful = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b] = [data[i], data[i + 1], data[i + 2]];
    if (Math.max(r, g, b) - Math.min(r, g, b) > 60) colourful++;
    counts[((r >> 4) << 8) | ((g >> 4) << 4) | (b >> 4)]++;
  }
  const pixels = width * height;
  return {
    width,
    height,
    colourful: colourful / pixels,
    colours: counts.filter((count) => count > 0.0005 * pixels).length,
    still: Math.max(...counts) / pixels,
  };
}

/** Whether two colours, of which the bytes stand at these places, differ by more than `most` in a channel. */
function differ(a, i, b, j, most) {
  for (let c = 0; c < 3; c++) if (Math.abs(a[i + c] - b[j + c]) > most) return true;
  return false;
}

/** The share of pixels that differ by more than 40 of 255 in a channel. */
export function difference(one, other) {
  const [a, b] = [decodePng(one), decodePng(other)];
  if (a.width !== b.width || a.height !== b.height) return 1;
  let differing = 0;
  for (let i = 0; i < a.data.length; i += 4) if (differ(a.data, i, b.data, i, 40)) differing++;
  return differing / (a.width * a.height);
}

/** The share of pixels near a colour (`#rrggbb`), within 30 of 255 in each channel. */
export function shareOf(png, colour) {
  const wanted = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  const { data, width, height } = decodePng(png);
  let near = 0;
  for (let i = 0; i < data.length; i += 4) if (!differ(data, i, wanted, 0, 30)) near++;
  return near / (width * height);
}

/** The box of the pixels within a part of a picture that differ from its top left one by more than 40 of 255. */
export function boxOfWhatIsDrawn(png, part = {}) {
  const { data, width, height } = decodePng(png);
  const { left, top, right, bottom } = { left: 0, top: 0, right: width, bottom: height, ...part };
  const ground = 4 * (top * width + left);
  const box = { left: right, top: bottom, right: left, bottom: top };
  for (let y = top; y < bottom; y++) {
    for (let x = left; x < right; x++) {
      if (!differ(data, 4 * (y * width + x), data, ground, 40)) continue;
      box.left = Math.min(box.left, x);
      box.right = Math.max(box.right, x + 1);
      box.top = Math.min(box.top, y);
      box.bottom = Math.max(box.bottom, y + 1);
    }
  }
  return box;
}
