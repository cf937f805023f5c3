// Numbers and names as people read them.

export const RPM_PER_RAD_S = 60 / (2 * Math.PI);

// Four figures at a steady width: what stands still does not jump.
export function number(value, figures = 4) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size >= 1e6) return value.toExponential(figures - 2).replace("e+", "e");
  const places = Math.max(0, figures - 1 - Math.max(0, Math.floor(Math.log10(Math.max(size, 1e-9)))));
  return (Math.abs(value) < 0.5 * 10 ** -places ? 0 : value).toFixed(Math.min(places, 6)).replace("-", "−");
}

// A parameter as the drive holds it (single precision), without digits that mean nothing.
export const exact = (value) => String(Number(Number(value).toPrecision(7)));

// A number as people write it: 30, -0.5, 1e3, also 30,5; null for anything else.
export function parseNumber(text) {
  const plain = text.trim().replace("−", "-").replace(/^([^.,]*),([^.,]*)$/, "$1.$2");
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain)) return null;
  const value = Number(plain);
  return Number.isFinite(value) ? value : null;
}

export const withUnit = (text, unit) => (unit ? `${text} ${unit}` : text);

export function seconds(value, figures = 3) {
  const size = Math.abs(value);
  if (size < 1e-3) return `${number(value * 1e6, figures)} µs`;
  if (size < 1) return `${number(value * 1e3, figures)} ms`;
  return `${number(value, figures)} s`;
}

export const isReference = (name) => /_ref(_|$)/.test(name);
