/** Uses the brush of examples/brush.js as a hand with a mouse would. */
const found = {};
try {
  const { paint, brush } = await import('/examples/brush.js');
  const canvas = document.querySelector('canvas');
  const painted = () => paint.array.reduce((sum, p) => sum + (p > 0), 0);
  const asked = () =>
    performance.getEntriesByType('resource').filter(({ name }) => name.includes('/distance')).length;
  // Moves until the condition holds: a move while a question is under way asks nothing.
  const move = async (x, y, buttons, condition) => {
    for (let i = 0; i < 1200 && !condition(); ++i) {
      canvas.dispatchEvent(
        new PointerEvent('pointermove', { clientX: x * innerWidth, clientY: y * innerHeight, buttons }),
      );
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
  };
  await move(0.5, 0.5, 0, () => asked() >= 2);
  found.hovered = painted();
  found.radius = brush.value;
  await move(0.5, 0.5, 1, () => painted() > 0);
  found.painted = painted();
  const before = asked();
  await move(0.01, 0.01, 1, () => asked() >= before + 2);
  found.beside = painted();
  dispatchEvent(new WheelEvent('wheel', { deltaY: -300 }));
  await move(0.5, 0.5, 1, () => painted() > found.painted);
  found.wider = painted();
} catch (error) {
  found.error = String(error?.stack ?? error);
}
await fetch('/found', { method: 'POST', body: JSON.stringify(found) });
