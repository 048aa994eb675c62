/** The whole state as one string for the address: a version, a check sum, and the state. */

import { Refusal } from "../refusal";
import { crc32 } from "../save/zip";
import { readState } from "./read";
import type { State } from "./state";

/** Of an address. */
const VERSION = "u2";

/** The state as JSON text, codes as lists of numbers. */
export function toJson(state: State, indent?: number): string {
  const plain = (_key: string, value: unknown) =>
    value instanceof Float32Array ? Array.from(value, (x) => Number(x.toPrecision(8))) : value;
  return JSON.stringify(state, plain, indent);
}

/** The state's part of the address, without "#". */
export function toAddress(state: State): string {
  const bytes = new TextEncoder().encode(toJson(state));
  return `${VERSION}.${checkSum(bytes)}.${base64(bytes)}`;
}

/**
 * The state of an address.
 *
 * @throws Refusal if it is of another version, shortened, or damaged.
 */
export function fromAddress(address: string): State {
  const [version, sum, text, ...rest] = address.replace(/^#/, "").split(".");
  if (version !== VERSION)
    throw new Refusal("The address was made by another version of this page.");
  const bytes = rest.length === 0 && sum && text ? fromBase64(text) : null;
  if (bytes === null || checkSum(bytes) !== sum)
    throw new Refusal("The address is incomplete; copy it again, up to its end.");
  return readState(JSON.parse(new TextDecoder().decode(bytes)));
}

/** CRC-32 in base 36. */
export function checkSum(bytes: Uint8Array): string {
  return crc32(bytes).toString(36);
}

function base64(bytes: Uint8Array): string {
  let binary = "";
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

function fromBase64(text: string): Uint8Array | null {
  try {
    const binary = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
    return Uint8Array.from(binary, (character) => character.charCodeAt(0));
  } catch {
    return null;
  }
}
