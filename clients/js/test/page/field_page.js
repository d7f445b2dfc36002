/** Runs examples/field.js and tells how many colours its canvas has. */
const found = {};
try {
  await import('/examples/field.js');
  const canvas = document.querySelector('canvas');
  const sheet = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d');
  sheet.drawImage(canvas, 0, 0); // in the task of its frame, so that it still is there
  const { data } = sheet.getImageData(0, 0, canvas.width, canvas.height);
  const hues = new Set();
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b] = data.subarray(i, i + 3);
    if (Math.max(r, g, b) - Math.min(r, g, b) > 60) hues.add(((r >> 5) << 6) | ((g >> 5) << 3) | (b >> 5));
  }
  found.hues = hues.size;
} catch (error) {
  found.error = String(error?.stack ?? error);
}
await fetch('/found', { method: 'POST', body: JSON.stringify(found) });
