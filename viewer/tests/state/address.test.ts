import { expect, test } from "vitest";
import type { MaterialCards } from "../../src/material/material";
import { Refusal } from "../../src/refusal";
import { checkSum, fromAddress, toAddress } from "../../src/state/address";
import { INITIAL, type State } from "../../src/state/state";

const LACQUER: MaterialCards = {
  name: "漆 – lacquer",
  bottom: {
    kind: "codes",
    latents: new Float32Array([1.5, -2.25, 1e-3]),
  },
  coats: [{ id: 1, on: false, alpha: 0.1, ior: 1.5, albedo: [0.1, 0.2, 0.3], sigmaT: 1, g: -0.5 }],
  solo: 1,
};
const CODES: State = { ...INITIAL, materials: [LACQUER, INITIAL.materials[1]] };

test("an address holds codes, too", () => {
  const address = toAddress(CODES);
  expect(fromAddress(`#${address}`)).toEqual(CODES);
  expect(address).toMatch(/^u2\.[0-9a-z]+\.[\w-]+$/);
});

test("the check sum is that of ISO 3309", () => {
  const sum = checkSum(new TextEncoder().encode("123456789"));
  expect(Number.parseInt(sum, 36)).toBe(0xcbf43926);
});

test("any changed or missing character is noticed", () => {
  const address = toAddress(INITIAL);
  const start = address.lastIndexOf(".") + 1;
  for (let at = start; at < address.length; at += 37) {
    const other = address[at] === "A" ? "B" : "A";
    expect(() => fromAddress(address.slice(0, at) + other + address.slice(at + 1))).toThrow(
      Refusal,
    );
    expect(() => fromAddress(address.slice(0, at))).toThrow("incomplete");
  }
});

test("another version is named as the reason", () => {
  expect(() => fromAddress(toAddress(INITIAL).replace("u2", "u3"))).toThrow("another version");
});
