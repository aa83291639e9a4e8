// A bound as people read it: never below it. The same as tools/brief_up.hpp, which the program has.

/**
 * The least number of `digits` significant digits that is not below `bound`, but for what rounding may have added to it
 * (1e-12 of it). `bound` >= 0.
 */
export function briefUp(bound, digits = 4) {
  const nearest = Number(bound.toPrecision(digits));
  if (!Number.isFinite(bound) || nearest >= bound * (1 - 1e-12)) return String(nearest);
  const [, exponent] = nearest.toExponential(digits - 1).split("e");
  return String(Number((nearest + 10 ** (exponent - digits + 1)).toPrecision(digits)));
}

/** Of a bound as a fraction. */
export function percentUp(fraction) {
  return `${briefUp(100 * fraction, 3)} %`;
}
