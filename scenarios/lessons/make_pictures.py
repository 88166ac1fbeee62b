#!/usr/bin/env python3
"""Draws the picture of each lesson anew: the film of its run at the time that its page names.

Usage: scenarios/lessons/make_pictures.py TAKT [NN ...]

A page says '![...](images/NN-name.jpg "at 1.2 s")'. Needs ffmpeg.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGES = ROOT / "docs/lessons"
PICTURE = re.compile(r'!\[[^\]]*\]\((images/\S+\.jpg) "at ([\d.]+) s"\)')
LARGEST = 40_000  # bytes
BEFORE = 4.0  # s of the film before the picture: as long as paths stay


def draw(takt, lesson, time, out):
    with tempfile.TemporaryDirectory() as folder:
        film = pathlib.Path(folder) / "film.mp4"
        subprocess.run([takt, "run", lesson, "--log", "none", "--video", film, "--size", "768x432",
                        "--video-from", str(max(0.0, time - BEFORE)), "--video-to", str(time)], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-sseof", "-0.2", "-i", film, "-update", "1", "-vf", "scale=640:-1:flags=lanczos",
                        "-q:v", "4", out], check=True)
    size = out.stat().st_size
    if size > LARGEST:
        sys.exit(f"{out}: {size} bytes, at most {LARGEST}")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    takt, wanted = sys.argv[1], sys.argv[2:]
    (PAGES / "images").mkdir(exist_ok=True)
    for page in sorted(PAGES.glob("[0-9]*.md")):
        if wanted and page.stem[:2] not in wanted:
            continue
        picture = PICTURE.search(page.read_text())
        if not picture:
            sys.exit(f"{page}: no picture with a time")
        draw(takt, ROOT / "scenarios/lessons" / f"{page.stem}.json", float(picture.group(2)), PAGES / picture.group(1))


main()
