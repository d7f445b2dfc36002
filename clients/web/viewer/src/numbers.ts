/** Numbers as people read them: lengths, times, shares, and round steps between them. */

/** Four significant digits, without an exponent where that stays short. */
export function lengthText(value: number): string {
  if (!Number.isFinite(value)) return '∞';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e7 || size < 1e-4) return value.toExponential(3).replace('e+', 'e');
  const digits = Math.max(0, 3 - Math.floor(Math.log10(size)));
  return value.toLocaleString('en-GB', { minimumFractionDigits: digits, maximumFractionDigits: digits });
}

/** A coordinate on something of this size: as many digits as tell its places apart. */
export function coordinateText(value: number, size: number): string {
  const digits = Math.min(12, Math.max(0, 4 - Math.floor(Math.log10(size || 1))));
  const text = value.toLocaleString('en-GB', { maximumFractionDigits: digits, useGrouping: false });
  return text === '-0' ? '0' : text;
}

/** The same without zeros at the end: for ticks, which are round already. */
export function tickText(value: number): string {
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e7 || size < 1e-4)) return `${Number(value.toPrecision(3))}`;
  return Number(value.toPrecision(6)).toLocaleString('en-GB', { maximumFractionDigits: 7 });
}

/** Milliseconds, as seconds from one second on. */
export function timeText(ms: number): string {
  if (ms >= 1000) return `${(ms / 1000).toPrecision(3)} s`;
  return `${ms < 10 ? ms.toFixed(1) : ms.toFixed(0)} ms`;
}

/** A part of 1 in per cent, with two digits that count. */
export function shareText(part: number): string {
  const percent = 100 * part;
  if (percent === 0) return '0 %';
  if (percent < 0.0001) return '< 0.0001 %';
  return `${Number(percent.toPrecision(2))} %`;
}

export function countText(value: number): string {
  return value.toLocaleString('en-GB');
}

export function bytesText(bytes: number): string {
  if (bytes < 1e3) return `${bytes} B`;
  return bytes < 1e6 ? `${(bytes / 1e3).toFixed(0)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

const ROUND = [1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10];

/** The least round number not below `rough`, which is positive. */
export function roundStep(rough: number): number {
  const power = 10 ** Math.floor(Math.log10(rough));
  const part = rough / power;
  return power * (ROUND.find((step) => step >= part * (1 - 1e-9)) ?? 10);
}
