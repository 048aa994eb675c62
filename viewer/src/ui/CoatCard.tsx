/** The card of one coat. */

import { signal } from "@preact/signals";
import type { Channels } from "../core/api";
import { hex, transmission } from "../material/colour";
import {
  type CoatCard as Card,
  type CoatInAir,
  type Rgb,
  rgb,
  withoutCoat,
} from "../material/material";
import { COAT_PARAMETERS } from "../material/parameters";
import { announcement, changeMaterial, material } from "../state/store";
import { Field } from "./Field";
import { Icon } from "./icons";
import { WidthFields, withWidths } from "./WidthFields";

/** Cards that show their name alone. */
const folded = signal<ReadonlySet<number>>(new Set());

const SHOWN = ["ior", "sigmaT", "albedo", "g"] as const;
const COLOURED: ReadonlySet<keyof CoatInAir> = new Set(["sigmaT", "albedo", "g"]);

interface CoatCardProps {
  card: Card;
  name: string;
  seen: boolean;
  dragged: boolean;
  onMove: (step: number) => void;
  onDrag: (event: PointerEvent) => void;
}

export function CoatCard({ card, name, seen, dragged, onMove, onDrag }: CoatCardProps) {
  const isFolded = folded.value.has(card.id);
  const solo = material.value.solo === card.id;
  const replace = (next: Card, kind: string) => {
    const coats = material.value.coats.map((one) => (one.id === card.id ? next : one));
    changeMaterial({ ...material.value, coats }, kind);
  };
  const change = (next: Partial<Card>, kind = "") => replace({ ...card, ...next }, kind);
  const classes = ["card", seen ? "" : "unseen", dragged ? "dragged" : ""].join(" ");
  return (
    <li class={classes} aria-label={name} style={{ "--medium": mediumColour(card) }}>
      <header>
        <button
          type="button"
          class="icon-button grip"
          aria-label={`Move ${name}: arrow keys, or drag`}
          title="Drag, or use the arrow keys"
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
        >
          <Icon name="grip" />
        </button>
        <button
          type="button"
          class="title"
          aria-expanded={!isFolded}
          onClick={() => {
            const next = new Set(folded.value);
            if (!next.delete(card.id)) next.add(card.id);
            folded.value = next;
          }}
        >
          <span>{name}</span>
          <small>{kindOf(card)}</small>
        </button>
        <button
          type="button"
          class="icon-button solo"
          aria-label={`Solo ${name}`}
          aria-pressed={solo}
          title="Show this coat alone over the bottom"
          onClick={() => changeMaterial({ ...material.value, solo: solo ? null : card.id })}
        >
          S
        </button>
        <button
          type="button"
          class="icon-button eye"
          aria-label={`Show ${name}`}
          aria-pressed={card.on}
          title={card.on ? "Switch off" : "Switch on"}
          onClick={() => change({ on: !card.on })}
        >
          <Icon name={card.on ? "eye" : "hidden"} />
        </button>
        <button
          type="button"
          class="icon-button"
          aria-label={`Remove ${name}`}
          title="Remove"
          onClick={() => {
            changeMaterial(withoutCoat(material.value, card.id));
            announcement.value = `${name} was removed.`;
          }}
        >
          <Icon name="cross" />
        </button>
      </header>
      {!isFolded && (
        <div class="fields">
          <WidthFields
            owner={name}
            parameter={COAT_PARAMETERS.alpha}
            widths={card}
            onChange={(next, kind) => replace(withWidths(card, next), kind)}
          />
          {SHOWN.map((key) => (
            <Field
              key={key}
              owner={name}
              parameter={COAT_PARAMETERS[key]}
              value={card[key]}
              coloured={COLOURED.has(key) || typeof card[key] !== "number"}
              onChange={(value: Channels, kind: string) => change({ [key]: value }, kind)}
            />
          ))}
        </div>
      )}
    </li>
  );
}

/** What kind of coat it is, in a word or two. */
function kindOf(coat: CoatInAir): string {
  const depth = Math.max(...rgb(coat.sigmaT));
  const albedo = Math.max(...rgb(coat.albedo));
  const widest = Math.max(...rgb(coat.alpha), ...rgb(coat.alphaV ?? coat.alpha));
  const surface = widest > 0.2 ? "matt" : "glossy";
  if (depth < 0.005) return `${surface}, clear`;
  if (depth > 2.5) return `${surface}, opaque`;
  return albedo > 0.4 ? `${surface}, milky` : `${surface}, tinted`;
}

/** About the colour of the medium on white, for the card's edge. */
function mediumColour(coat: CoatInAir): string {
  const passed = transmission(rgb(coat.sigmaT));
  const scattered = rgb(coat.albedo).map(deepReflectance);
  const mixed = passed.map((x, k) => x * x + (1 - x * x) * scattered[k]!) as unknown as Rgb;
  return hex(mixed);
}

/** Reflectance of an infinitely deep medium (van de Hulst 1980). */
function deepReflectance(albedo: number): number {
  const s = Math.sqrt(1 - albedo);
  return ((1 - s) * (1 - 0.139 * s)) / (1 + 1.17 * s);
}
