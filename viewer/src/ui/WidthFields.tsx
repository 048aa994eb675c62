/** The widths of a surface: its gloss, and one width or two along and across the tangent. */

import type { Channels } from "../core/api";
import { alphaOf, GLOSS, glossOf, type Parameter, WIDTHS } from "../material/parameters";
import { Field } from "./Field";

export interface WidthPair {
  alpha: Channels;
  /** Undefined while the widths are linked. */
  alphaV?: Channels | undefined;
}

interface WidthFieldsProps {
  owner: string;
  /** Of the one width. */
  parameter: Parameter;
  widths: WidthPair;
  onChange: (next: WidthPair, kind: string) => void;
}

/** The gloss of a surface whose width is one number; others have none. */
export function GlossField({ owner, widths, onChange }: Omit<WidthFieldsProps, "parameter">) {
  const { alpha, alphaV } = widths;
  if (typeof alpha !== "number" || alphaV !== undefined) return null;
  return (
    <Field
      owner={owner}
      parameter={GLOSS}
      value={glossOf(alpha)}
      coloured={false}
      onChange={(gloss, kind) => onChange({ alpha: alphaOf(gloss as number) }, kind)}
    />
  );
}

export function WidthFields({ owner, parameter, widths, onChange }: WidthFieldsProps) {
  const { alpha, alphaV } = widths;
  const isLinked = alphaV === undefined;
  const link = (
    <button
      type="button"
      class="link"
      aria-pressed={!isLinked}
      aria-label={`${owner}, u·v: two widths`}
      title={isLinked ? "Two widths, along and across the tangent" : "One width"}
      onClick={() => onChange({ alpha, alphaV: isLinked ? alpha : undefined }, "")}
    >
      u·v
    </button>
  );
  return (
    <>
      <Field
        owner={owner}
        parameter={isLinked ? parameter : { ...WIDTHS.alpha, fallback: parameter.fallback }}
        value={alpha}
        coloured={typeof alpha !== "number"}
        aside={link}
        onChange={(value, kind) => onChange({ alpha: value, alphaV }, kind)}
      />
      {!isLinked && (
        <Field
          owner={owner}
          parameter={{ ...WIDTHS.alphaV, fallback: parameter.fallback }}
          value={alphaV}
          coloured={typeof alphaV !== "number"}
          onChange={(value, kind) => onChange({ alpha, alphaV: value }, kind)}
        />
      )}
    </>
  );
}

/** A surface with other widths; `alphaV` is left out while they are linked. */
export function withWidths<Surface extends object>(
  surface: Surface,
  { alpha, alphaV }: WidthPair,
): Surface {
  const { alphaV: _before, ...rest } = surface as Surface & { alphaV?: Channels };
  return { ...rest, alpha, ...(alphaV === undefined ? {} : { alphaV }) } as unknown as Surface;
}
