/** A small picture of a material. */

import { useEffect, useRef } from "preact/hooks";
import { THUMBNAIL_SIZE, thumbnailOf } from "../engine/thumbnails";
import type { MaterialCards } from "../material/material";

export function Thumbnail({ of }: { of: MaterialCards }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    let isSeen = true;
    void thumbnailOf(of).then((picture) => {
      if (isSeen && picture !== null) canvas.current?.getContext("2d")?.drawImage(picture, 0, 0);
    });
    return () => {
      isSeen = false;
    };
  }, [of]);
  return <canvas ref={canvas} width={THUMBNAIL_SIZE} height={THUMBNAIL_SIZE} aria-hidden="true" />;
}
