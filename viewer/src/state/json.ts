/** Reading JSON that may be anything: every reader gives a value within its range, or refuses. */

import { Refusal } from "../refusal";

export type Fields = Record<string, unknown>;

/** Gives the value of JSON, or the first one where that is missing or of another kind. */
type Reader<T> = (value: unknown) => T;

/** What readers of fields give. */
export type Values<Readers> = {
  [Name in keyof Readers]: Readers[Name] extends Reader<infer T> ? T : never;
};

export const flag: Reader<boolean> = (value) => value === true;

export function within(low: number, high: number, first: number): Reader<number> {
  return (value) =>
    typeof value === "number" && Number.isFinite(value)
      ? Math.min(Math.max(value, low), high)
      : first;
}

export function oneOf<T>(all: readonly T[], first: T): Reader<T> {
  return (value) => all.find((one) => one === value) ?? first;
}

export function text(first: string): Reader<string> {
  return (value) => (typeof value === "string" && value.trim().slice(0, 80).trim()) || first;
}

/** An object of fields. */
export function record<Readers extends Record<string, Reader<unknown>>>(
  readers: Readers,
): Reader<Values<Readers>> {
  return (value) =>
    Object.fromEntries(
      Object.entries(readers).map(([name, read]) => [name, read(Object(value)[name])]),
    ) as Values<Readers>;
}

/** @throws Refusal if it is no object. */
export function object(value: unknown, what: string): Fields {
  if (typeof value !== "object" || value === null || Array.isArray(value))
    throw new Refusal(`There is no description of ${what}.`);
  return value as Fields;
}
