/** The card of the bottom. */

import { useMemo } from "preact/hooks";
import type { Channels } from "../core/api";
import { type Rgb, rgb } from "../material/channels";
import { hex } from "../material/colour";
import {
  BARE,
  type BottomInAir,
  type CodesBottom,
  type MaterialCards,
  reflectanceOf,
  type TexelBottom,
  type Widths,
  widthsOf,
} from "../material/material";
import { BOTTOM_PARAMETERS, type Parameter } from "../material/parameters";
import { METALS } from "../material/presets";
import { changeMaterial, material } from "../state/store";
import { Button, IconButton } from "./Button";
import { Choice } from "./Choice";
import { Field } from "./Field";
import { Thumbnail } from "./Thumbnail";
import { GlossField, WidthFields, withWidths } from "./WidthFields";

const KINDS = {
  metal: "Metal by index",
  schlick: "Metal by reflectance",
  diffuse: "Matt (Lambertian)",
  dielectric: "Dielectric",
} as const;

type Kind = keyof typeof KINDS | "codes" | "texels";

type AnyBottom = MaterialCards["bottom"];

export function BottomCard() {
  const { bottom, name, solo } = material.value;
  const kind = kindOf(bottom);
  const bare = useMemo(() => ({ name, bottom, coats: [], solo: null }), [name, bottom]);
  const change = (next: AnyBottom, step = "") =>
    changeMaterial({ ...material.value, bottom: next }, step);
  const surface = {
    owner: "Bottom",
    widths: bottom as Widths,
    onChange: (next: Widths, step: string) => change(withWidths(bottom, next), step),
  };
  const field = ([key, parameter]: [string, Parameter]) => (
    <Field
      key={key}
      owner="Bottom"
      parameter={parameter}
      value={(bottom as unknown as Record<string, Channels>)[key]}
      coloured={kind !== "dielectric"}
      colourOf={(value) => reflectanceOf({ ...bottom, [key]: value } as BottomInAir)}
      onChange={(value, step) => change({ ...bottom, [key]: value } as BottomInAir, step)}
    />
  );
  const fields = Object.entries<Parameter>(BOTTOM_PARAMETERS).filter(
    ([key]) => key !== "alpha" && key in bottom,
  );
  const colours = fields.filter(([, { isColour }]) => isColour);
  const numbers = fields.filter(([, { isColour }]) => !isColour);
  return (
    <section
      class="card bottom"
      aria-label="Bottom"
      style={{ "--medium": hex(reflectanceOf(bottom)) }}
    >
      <header>
        <span class="title">Bottom</span>
        <Choice
          name="Kind of bottom"
          value={kind}
          options={[
            ...(Object.entries(KINDS) as [Kind, string][]),
            ...(kind === "codes" ? ([["codes", "Loaded material"]] as const) : []),
            ...(kind === "texels" ? ([["texels", "Loaded texture"]] as const) : []),
          ]}
          onChange={(next) => change(bottomOfKind(next, bottom))}
        />
        <IconButton
          class="solo"
          name="Solo the bottom"
          title="Show the bottom without coats"
          pressed={solo === BARE}
          onClick={() => changeMaterial({ ...material.value, solo: solo === BARE ? null : BARE })}
        >
          S
        </IconButton>
      </header>
      <div class="fields">
        {kind === "metal" && <Metals bottom={bottom} onChange={change} />}
        {colours.map(field)}
        {"alpha" in bottom && (
          <>
            <GlossField {...surface} />
            <details>
              <summary>Advanced</summary>
              <WidthFields parameter={BOTTOM_PARAMETERS.alpha} {...surface} />
              {numbers.map(field)}
            </details>
          </>
        )}
        {(bottom.kind === "codes" || bottom.kind === "texels") && (
          <div class="loaded">
            <Thumbnail of={bare} />
            <p class="note">
              <strong>{name}</strong> {noteOn(bottom)}
            </p>
          </div>
        )}
      </div>
    </section>
  );
}

/** How a loaded material is shown. */
function noteOn(bottom: CodesBottom | TexelBottom): string {
  if (bottom.kind === "texels")
    return "was loaded from a file with a texture; coat it in Python. The plots show its mean code.";
  const note = "was loaded from a file; its own coats keep their ratios of indices.";
  if (bottom.table === undefined) return note;
  return `${note} It is shown by its table, but under coats by its codes, which can differ from it by 10 to 40 %.`;
}

function Metals({
  bottom,
  onChange,
}: {
  bottom: AnyBottom;
  onChange: (next: BottomInAir) => void;
}) {
  const known = Object.entries(METALS).find(
    ([, metal]) =>
      "k" in bottom && same(rgb(bottom.eta), metal.eta) && same(rgb(bottom.k), metal.k),
  );
  return (
    <div class="chips" role="group" aria-label="Metals">
      {Object.entries(METALS).map(([name, { eta, k }]) => (
        <Button
          key={name}
          aria-pressed={known?.[0] === name}
          style={{ "--medium": hex(reflectanceOf({ kind: "conductor", alpha: 0, eta, k })) }}
          onClick={() => onChange({ kind: "conductor", ...widthsIn(bottom), eta, k })}
        >
          {name}
        </Button>
      ))}
    </div>
  );
}

function same(a: Rgb, b: Rgb): boolean {
  return a.every((x, k) => Math.abs(x - b[k]) < 1e-6);
}

function kindOf(bottom: AnyBottom): Kind {
  if (bottom.kind !== "conductor") return bottom.kind;
  return "r0" in bottom ? "schlick" : "metal";
}

const widthsIn = (bottom: AnyBottom) =>
  widthsOf("alpha" in bottom ? bottom : { alpha: BOTTOM_PARAMETERS.alpha.fallback });

/** A bottom of another kind that looks like the present one where it can; no metal is as dark as paint. */
function bottomOfKind(kind: Kind, bottom: AnyBottom): AnyBottom {
  const widths = widthsIn(bottom);
  const colour = reflectanceOf(bottom);
  switch (kind) {
    case "metal":
      return { kind: "conductor", ...widths, ...METALS.Gold! };
    case "schlick":
      return { kind: "conductor", ...widths, r0: "k" in bottom ? colour : 0.9 };
    case "dielectric":
      return { kind: "dielectric", ...widths, ior: 1.5 };
    case "diffuse":
      return { kind: "diffuse", reflectance: colour };
    case "codes":
    case "texels":
      return bottom;
  }
}
