/** What the page writes: pictures, descriptions, and its address. */

import { stackOf } from "../material/material";
import { download, textBlob } from "../save/download";
import { mitsubaDict, mitsubaXml } from "../save/mitsuba";
import { fileName, pythonText } from "../save/python";
import { toJson } from "../state/address";
import { Refusal } from "../state/read";
import { announcement, material, notice, state } from "../state/store";

/** A kind of file: its name in the menu, what it is, and what makes it. */
interface Kind {
  label: string;
  hint: string;
  save: (name: string) => void | Promise<void>;
}

const stack = () => stackOf(material.value);

const KINDS: readonly Kind[] = [
  {
    label: "Picture",
    hint: "PNG, as it is seen",
    save: async (name) => {
      const canvas = document.querySelector<HTMLCanvasElement>(".stage canvas")!;
      const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, "image/png"));
      if (blob === null) throw new Refusal("There is no picture to save.");
      download(`${name}.png`, blob);
    },
  },
  {
    label: "Mitsuba XML",
    hint: "a BSDF for a scene file",
    save: (name) => download(`${name}.xml`, textBlob(mitsubaXml(stack()))),
  },
  {
    label: "Mitsuba dictionary",
    hint: "the same for mi.load_dict",
    save: (name) => download(`${name}-dict.py`, textBlob(mitsubaDict(stack()))),
  },
  {
    label: "Python",
    hint: "a program with urushi",
    save: (name) => download(`${name}.py`, textBlob(pythonText(stack(), material.value.name))),
  },
  {
    label: "State",
    hint: "JSON, to open here again",
    save: (name) => download(`${name}.json`, textBlob(toJson(state.value, 2))),
  },
  {
    label: "Copy the address",
    hint: "it holds the whole state",
    save: async () => {
      await navigator.clipboard.writeText(location.href);
      announcement.value = "The address was copied.";
    },
  },
];

export function SaveMenu({ onDone }: { onDone: () => void }) {
  const run = async (kind: Kind) => {
    onDone();
    try {
      await kind.save(fileName(material.value.name));
    } catch (error) {
      if (error instanceof Refusal) notice.value = error.message;
      else if (error instanceof DOMException)
        notice.value = "The browser did not allow it; copy the address from the address bar.";
      else throw error;
    }
  };
  return (
    <ul>
      {KINDS.map((kind) => (
        <li key={kind.label}>
          <button type="button" onClick={() => void run(kind)}>
            <span>{kind.label}</span>
            <small>{kind.hint}</small>
          </button>
        </li>
      ))}
    </ul>
  );
}
