// Pixels of a PNG as browsers write it. Node unpacks a picture many times faster than a page would.
import { inflateSync } from 'node:zlib';

const SIGNATURE = Buffer.from('89504e470d0a1a0a', 'hex');
const CHANNELS = { 2: 3, 6: 4 }; // by the type of colour: RGB, RGBA

/** The chunks of a PNG: type and data. */
function* chunksOf(png) {
  if (!png.subarray(0, 8).equals(SIGNATURE)) throw new Error('no PNG');
  for (let at = 8; at < png.length; ) {
    const size = png.readUInt32BE(at);
    yield [png.toString('latin1', at + 4, at + 8), png.subarray(at + 8, at + 8 + size)];
    at += size + 12;
  }
}

/** Paeth's predictor: whichever of left, above and above left is nearest to left + above - above left. */
function paeth(left, above, corner) {
  const toLeft = Math.abs(above - corner);
  const toAbove = Math.abs(left - corner);
  const toCorner = Math.abs(left + above - 2 * corner);
  if (toLeft <= toAbove && toLeft <= toCorner) return left;
  return toAbove <= toCorner ? above : corner;
}

/** `data` (RGBA), `width` and `height` of a PNG of 8 bits a channel, in colour, not interlaced. */
export function decodePng(png) {
  const chunks = [...chunksOf(png)];
  const [, header] = chunks[0];
  const [width, height] = [header.readUInt32BE(0), header.readUInt32BE(4)];
  const [depth, colour, , , interlaced] = header.subarray(8);
  const channels = CHANNELS[colour];
  if (depth !== 8 || !channels || interlaced) throw new Error(`a PNG of ${depth} bits, colour ${colour}, interlaced ${interlaced}`);
  const packed = inflateSync(Buffer.concat(chunks.filter(([type]) => type === 'IDAT').map(([, data]) => data)));
  const stride = width * channels;
  const data = new Uint8ClampedArray(4 * width * height).fill(255);
  let before = new Uint8Array(stride);
  for (let y = 0; y < height; y++) {
    const start = y * (stride + 1);
    const filter = packed[start];
    const row = packed.subarray(start + 1, start + 1 + stride);
    for (let i = 0; filter && i < stride; i++) {
      const left = i < channels ? 0 : row[i - channels];
      if (filter === 1) row[i] += left;
      else if (filter === 2) row[i] += before[i];
      else if (filter === 3) row[i] += (left + before[i]) >> 1;
      else row[i] += paeth(left, before[i], i < channels ? 0 : before[i - channels]);
    }
    for (let x = 0, from = 0, to = 4 * y * width; x < width; x++, to += 4) {
      for (let c = 0; c < channels; c++) data[to + c] = row[from++];
    }
    before = row;
  }
  return { data, width, height };
}
