"""Stores pictures as small JPEG files: python docs/small_jpg.py PICTURE... FOLDER"""

import sys
from pathlib import Path

import mitsuba as mi

QUALITY = 88


def main(pictures: list[Path], folder: Path) -> None:
    mi.set_variant("scalar_rgb")
    for picture in pictures:
        bitmap = mi.Bitmap(str(picture)).convert(mi.Bitmap.PixelFormat.RGB)
        bitmap.write(str(folder / f"{picture.stem}.jpg"), quality=QUALITY)


if __name__ == "__main__":
    *pictures, folder = map(Path, sys.argv[1:])
    main(pictures, folder)
