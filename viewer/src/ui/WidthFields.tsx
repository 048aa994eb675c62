/** The widths of a surface: its gloss, and one width or two along and across the tangent. */

import { type Widths, widthsOf } from "../material/material";
import { alphaOf, GLOSS, glossOf, type Parameter, WIDTHS } from "../material/parameters";
import { Button } from "./Button";
import { Field } from "./Field";

interface WidthFieldsProps {
  owner: string;
  /** Of the one width. */
  parameter: Parameter;
  widths: Widths;
  onChange: (next: Widths, kind: string) => void;
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
    <Button
      class="link"
      aria-pressed={!isLinked}
      aria-label={`${owner}, u·v: two widths`}
      title={isLinked ? "Two widths, along and across the tangent" : "One width"}
      onClick={() => onChange({ alpha, alphaV: isLinked ? alpha : undefined }, "")}
    >
      u·v
    </Button>
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

/** A surface with other widths. */
export function withWidths<Surface extends object>(surface: Surface, widths: Widths): Surface {
  const { alphaV: _before, ...rest } = surface as Surface & Widths;
  return { ...rest, ...widthsOf(widths) } as unknown as Surface;
}
