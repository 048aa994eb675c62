/** The materials to begin with, as small pictures. */

import { useEffect, useRef } from "preact/hooks";
import { drawThumbnails } from "../engine/thumbnails";
import { PRESETS } from "../material/presets";
import { changeMaterial, material } from "../state/store";

export function Presets({ onChosen }: { onChosen: () => void }) {
  const list = useRef<HTMLUListElement>(null);
  useEffect(() => {
    const canvases = [...(list.current?.querySelectorAll("canvas") ?? [])];
    let open = true;
    void drawThumbnails(canvases, () => open);
    return () => {
      open = false;
    };
  }, []);
  return (
    <ul ref={list}>
      {PRESETS.map((preset) => (
        <li key={preset.name}>
          <button
            type="button"
            aria-pressed={preset.name === material.value.name}
            onClick={() => {
              changeMaterial(preset);
              onChosen();
            }}
          >
            <canvas width={112} height={112} aria-hidden="true" />
            <span>{preset.name}</span>
          </button>
        </li>
      ))}
    </ul>
  );
}
