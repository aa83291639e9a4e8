// Bounds in few digits: not below the bound, and no more above it than the last digit counts. As
// tests/unit/brief_up_test.cpp; needs no browser.
import assert from "node:assert/strict";
import test from "node:test";
import { briefUp, percentUp } from "./page/brief-up.js";

test("a bound is shown rounded up", () => {
  assert.equal(briefUp(0), "0");
  assert.equal(briefUp(1.0124, 3), "1.02");
  assert.equal(briefUp(1.02, 3), "1.02");
  assert.equal(briefUp(0.0302149), "0.03022");
  assert.equal(briefUp(9.9991, 3), "10");
  assert.equal(briefUp(999.2, 3), "1000");
  assert.equal(briefUp(129.71), "129.8");
  assert.equal(briefUp(123456), "123500");
  assert.equal(briefUp(3.1e-7, 1), "4e-7");
  assert.equal(briefUp(2.0000000000000004, 3), "2"); // rounding of a quotient
  assert.equal(briefUp(Infinity), "Infinity");
  assert.equal(percentUp(0.019401), "1.95 %");
  assert.equal(percentUp(0.2), "20 %");
  assert.equal(percentUp(20), "2000 %");
});

test("shown bounds are bounds, and close", () => {
  let state = 1;
  const random = (count) => (state = (state * 48271) % 2147483647) % count;
  for (let i = 0; i < 20000; ++i) {
    const bound = (1 + random(1000000)) * 10 ** (random(40) - 25);
    const shown = Number(briefUp(bound, 3));
    assert.ok(shown >= bound * (1 - 1e-12) && shown <= bound * 1.0101, `${bound} is shown as ${shown}`);
  }
});
