"""A short film that moves through a panorama, as an animated WebP.

  film.py room.ldp film.webp [sway|walk|dolly]
"""
import sys

import ldp
from PIL import Image


def main(file, output, path="sway"):
    panorama = ldp.open(file)
    cameras = panorama.path(path, frames=30, size=(480, 360))
    views = [panorama.render(camera, fill="background", depth=False) for camera in cameras]
    first, *others = [Image.fromarray(view.rgb) for view in views]
    first.save(output, save_all=True, append_images=others, duration=40, loop=0)


if __name__ == "__main__":
    main(*sys.argv[1:])
