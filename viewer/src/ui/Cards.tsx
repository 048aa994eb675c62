/** The stack as cards, the topmost coat first. */

import { signal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { rgb } from "../material/channels";
import {
  type CoatCard as Card,
  givesBack,
  hasTangent,
  moved,
  takesCoat,
  withCoat,
} from "../material/material";
import { ANGLE } from "../material/parameters";
import { announce, changeMaterial, material } from "../state/store";
import { BottomCard } from "./BottomCard";
import { Button } from "./Button";
import { CoatCard } from "./CoatCard";
import { Field } from "./Field";
import { Icon } from "./icons";

/** The coat that is being dragged. */
const dragged = signal<number | null>(null);

export function Cards() {
  const list = useRef<HTMLUListElement>(null);
  const { coats } = material.value;

  const move = (from: number, to: number) => {
    if (to < 0 || to >= coats.length || from === to) return;
    changeMaterial(moved(material.value, from, to), `move ${coats[from].id}`);
    announce(`Coat moved to place ${to + 1} of ${coats.length}.`);
  };

  const startDrag = (event: PointerEvent, card: Card) => {
    if (event.button !== 0 || list.current === null) return;
    const handle = event.currentTarget as HTMLElement;
    handle.setPointerCapture(event.pointerId);
    dragged.value = card.id;
    const kind = `drag ${card.id} at ${event.timeStamp}`; // one step of the history
    const follow = (now: PointerEvent) => {
      const present = material.value.coats;
      const from = present.findIndex((coat) => coat.id === card.id);
      const boxes = [...(list.current?.children ?? [])].map((x) => x.getBoundingClientRect());
      // The pointer passes a neighbour where the dragged card would then lie under it.
      const before = boxes[from - 1];
      const after = boxes[from + 1];
      const own = boxes[from];
      if (own === undefined) return;
      if (before && now.clientY < before.top + Math.min(before.height / 2, own.height))
        changeMaterial(moved(material.value, from, from - 1), kind);
      else if (after && now.clientY > after.bottom - Math.min(after.height / 2, own.height))
        changeMaterial(moved(material.value, from, from + 1), kind);
    };
    const stop = () => {
      dragged.value = null;
      handle.removeEventListener("pointermove", follow);
      handle.removeEventListener("lostpointercapture", stop);
    };
    handle.addEventListener("pointermove", follow);
    handle.addEventListener("lostpointercapture", stop);
  };

  return (
    <section class="cards" aria-label="Stack of layers">
      <div class="cards-head">
        <h2>Layers</h2>
        <Button
          class="quiet"
          aria-disabled={!takesCoat(material.value)}
          title={
            takesCoat(material.value)
              ? "Add a clear coat on top"
              : "Six coats are the most, and a texture of codes has none"
          }
          onClick={() => {
            if (!takesCoat(material.value)) return;
            changeMaterial(withCoat(material.value));
            announce("A coat was added on top.");
          }}
        >
          <Icon name="plus" /> Add coat
        </Button>
      </div>
      <ul ref={list} aria-label="Coats, the topmost first">
        {coats.map((card, place) => (
          <CoatCard
            key={card.id}
            card={card}
            name={`Coat ${coats.length - place}`}
            dragged={dragged.value === card.id}
            onMove={(step) => move(place, place + step)}
            onDrag={(event) => startDrag(event, card)}
          />
        ))}
      </ul>
      <BottomCard />
      {(coats.length > 0 || material.value.bottom.kind === "conductor") && (
        <label
          class="switch"
          title={
            givesBack(material.value)
              ? "Light that meets a second facet of the topmost surface is given back"
              : "Materials of two widths, and bare ones but metals, have none"
          }
        >
          <input
            type="checkbox"
            disabled={!givesBack(material.value)}
            checked={material.value.energyCompensation === true}
            onChange={({ currentTarget: { checked } }) =>
              changeMaterial({ ...material.value, energyCompensation: checked })
            }
          />
          Energy compensation
        </label>
      )}
      {hasTangent(material.value) && (
        <div class="fields tangent">
          <Field
            owner="Material"
            parameter={ANGLE}
            value={material.value.rotation ?? 0}
            coloured={false}
            onChange={(value, kind) =>
              changeMaterial({ ...material.value, rotation: rgb(value)[0] }, kind)
            }
          />
        </div>
      )}
    </section>
  );
}
