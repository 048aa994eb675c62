/** The card of one coat. */

import { useSignal } from "@preact/signals";
import type { Channels } from "../core/api";
import { withinTraining } from "../core/layerer";
import { coatOfChannel } from "../core/surfaces";
import {
  colourOf,
  colourOver,
  type Look,
  lookOf,
  type Physics,
  physicsOf,
  withColour,
  withOpacity,
} from "../material/appearance";
import { mapped, type Rgb, rgb } from "../material/channels";
import { hex } from "../material/colour";
import {
  type CoatCard as Card,
  type CoatInAir,
  hasSurface,
  isSeen,
  type Widths,
  withoutCoat,
} from "../material/material";
import { COAT_PARAMETERS, COLOUR, rounded } from "../material/parameters";
import { announce, changeMaterial, material } from "../state/store";
import { Button, IconButton } from "./Button";
import { Field } from "./Field";
import { GlossField, WidthFields, withWidths } from "./WidthFields";

interface CoatCardProps {
  card: Card;
  name: string;
  dragged: boolean;
  onMove: (step: number) => void;
  onDrag: (event: PointerEvent) => void;
}

export function CoatCard({ card, name, dragged, onMove, onDrag }: CoatCardProps) {
  const isFolded = useSignal(false);
  const solo = material.value.solo === card.id;
  const replace = (next: Card, kind: string) => {
    const coats = material.value.coats.map((one) => (one.id === card.id ? next : one));
    changeMaterial({ ...material.value, coats }, kind);
  };
  const change = (next: Partial<Card>, kind = "") => replace({ ...card, ...next }, kind);
  const look = lookOf(card);
  const hasOwnSurface = hasSurface(material.value, card);
  const mediumField = (key: MediumKey) => {
    const changed = (value: Channels) => withMedium(card, key, value);
    const value = mediumValue(card, key);
    return (
      <Field
        owner={name}
        parameter={COAT_PARAMETERS[key]}
        value={value}
        coloured={key === "body" ? typeof value !== "number" : key !== "thickness"}
        colourOf={key === "g" ? undefined : (other) => shownColour(changed(other))}
        onChange={(other, kind) => replace(changed(other), kind)}
      />
    );
  };
  const surface = {
    owner: name,
    widths: card,
    onChange: (next: Widths, kind: string) => replace(withWidths(card, next), kind),
  };
  const classes = [
    "card",
    isSeen(material.value, card) ? "" : "unseen",
    dragged ? "dragged" : "",
  ].join(" ");
  return (
    <li class={classes} aria-label={name} style={{ "--medium": hex(shownColour(card)) }}>
      <header>
        <IconButton
          class="grip"
          name={`Move ${name}: arrow keys, or drag`}
          title="Drag, or use the arrow keys"
          icon="grip"
          onPointerDown={onDrag}
          onKeyDown={(event) => {
            const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
            if (step === undefined) return;
            event.preventDefault();
            onMove(step);
            // The handle moves with its card and keeps the focus.
            const handle = event.currentTarget;
            requestAnimationFrame(() => handle.focus());
          }}
        />
        <Button
          class="title"
          aria-expanded={!isFolded.value}
          onClick={() => {
            isFolded.value = !isFolded.value;
          }}
        >
          <span>{name}</span>
          <small>{kindOf(card, hasOwnSurface)}</small>
        </Button>
        <IconButton
          class="solo"
          name={`Solo ${name}`}
          title="Show this coat alone over the bottom"
          pressed={solo}
          onClick={() => changeMaterial({ ...material.value, solo: solo ? null : card.id })}
        >
          S
        </IconButton>
        <IconButton
          class="eye"
          name={`Show ${name}`}
          title={card.on ? "Switch off" : "Switch on"}
          icon={card.on ? "eye" : "hidden"}
          pressed={card.on}
          onClick={() => change({ on: !card.on })}
        />
        <IconButton
          name={`Remove ${name}`}
          title="Remove"
          icon="cross"
          onClick={() => {
            changeMaterial(withoutCoat(material.value, card.id));
            announce(`${name} was removed.`);
          }}
        />
      </header>
      {!isFolded.value && (
        <div class="fields">
          <Field
            owner={name}
            parameter={COLOUR}
            value={mapped(colourOf(look), rounded)}
            coloured
            colourOf={(value) => shownColour(withColour(card, value))}
            onChange={(value, kind) => replace(withColour(card, value), kind)}
          />
          {hasOwnSurface ? (
            <GlossField {...surface} />
          ) : (
            <p class="note">No surface, so no gloss: its index n is that of the coat above.</p>
          )}
          {mediumField("thickness")}
          {mediumField("body")}
          <details>
            <summary>Advanced</summary>
            {mediumField("color")}
            {mediumField("bodyColor")}
            {hasOwnSurface && <WidthFields parameter={COAT_PARAMETERS.alpha} {...surface} />}
            <Field
              owner={name}
              parameter={COAT_PARAMETERS.ior}
              value={card.ior}
              coloured={typeof card.ior !== "number"}
              onChange={(ior, kind) => change({ ior }, kind)}
            />
            {mediumField("sigmaT")}
            {mediumField("albedo")}
            {mediumField("g")}
            <Replaced card={card} />
          </details>
        </div>
      )}
    </li>
  );
}

/** What is said of a medium that is too deep, or too directed, to be shown as it is. */
function Replaced({ card }: { card: Card }) {
  const { albedo, sigmaT } = physicsOf(card);
  const coat = { alpha: 1, eta: 1.5, albedo, g: card.g };
  const depths = ([0, 1, 2] as const).map((channel) => {
    const depth = rgb(sigmaT)[channel] * (card.thickness ?? 1);
    const own = coatOfChannel({ ...coat, sigmaT: depth }, channel);
    const shown = withinTraining(own);
    return shown === own ? null : rounded(shown.sigmaT);
  });
  if (depths.every((depth) => depth === null)) return null;
  const told = new Set(depths.filter((depth) => depth !== null));
  return <p class="note">A medium that looks alike is shown, of depth {[...told].join(", ")}.</p>;
}

/** A parameter of the medium: of its appearance or of its physics, whichever was given. */
type MediumKey = keyof Look | keyof Physics | "thickness" | "g";

/** A parameter of a coat's medium, however it was given. */
function mediumValue(card: Card, name: MediumKey): Channels {
  if (name === "thickness") return card.thickness ?? 1;
  const all = { ...lookOf(card), ...physicsOf(card), g: card.g };
  return mapped(all[name], rounded);
}

/** A coat with another value of its medium, which is then given by that value's kind. */
function withMedium(card: Card, name: MediumKey, value: Channels): Card {
  if (name === "thickness") return { ...card, thickness: rgb(value)[0] };
  if (name === "g") return { ...card, g: value };
  if (name === "body") return withOpacity(card, value);
  const { color, body, bodyColor, albedo, sigmaT, ...others } = card as Card & Look & Physics;
  const given = name === "albedo" || name === "sigmaT" ? physicsOf(card) : lookOf(card);
  const numbers = Object.entries(given).map(([key, x]) => [key, mapped(x as Channels, rounded)]);
  return { ...others, ...Object.fromEntries(numbers), [name]: value } as Card;
}

/** What kind of coat it is, in a word or two. */
function kindOf(coat: CoatInAir, hasOwnSurface: boolean): string {
  const { color, body } = lookOf(coat);
  const opaque = Math.max(...rgb(body));
  const widest = Math.max(...rgb(coat.alpha), ...rgb(coat.alphaV ?? coat.alpha));
  const surface = !hasOwnSurface ? "no surface" : widest > 0.2 ? "matt" : "glossy";
  if (opaque > 0.6) return `${surface}, opaque`;
  if (opaque > 0.02) return `${surface}, milky`;
  return Math.min(...rgb(color)) > 0.99 ? `${surface}, clear` : `${surface}, tinted`;
}

/** About the colour of a coat on white. */
function shownColour(coat: CoatInAir): Rgb {
  return colourOver(coat, coat.thickness ?? 1);
}
