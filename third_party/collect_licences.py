#!/usr/bin/env python3
"""Copies the licence texts of what a program is made of out of Debian's packages.

Usage: collect_licences.py PROGRAM FOLDER [HEADER...]

FOLDER gets one PACKAGE.txt for the package of each shared library that PROGRAM names as needed, and of each header, whose
code is compiled into it. A file that belongs to no package (one's own build of a library) is named on stderr: its
licence is for whoever built it to add.
"""
import pathlib
import re
import shutil
import subprocess
import sys


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout


def needed_libraries(program):
    names = re.findall(r"\(NEEDED\).*\[(.+)\]", output("readelf", "--dynamic", "--wide", program))
    paths = dict(re.findall(r"^\s*(\S+) => (/\S+)", output("ldd", program), re.MULTILINE))
    return [paths[name] for name in names if name in paths]


def package_of(file):
    """Files of /lib are listed as such or below /usr, whatever links there are between the two."""
    real = str(pathlib.Path(file).resolve())
    for path in (file, real, real.removeprefix("/usr")):
        listed = output("dpkg-query", "--search", path)
        if listed:
            return listed.split(":")[0]
    return None


def main():
    program, folder, headers = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3:]
    if not shutil.which("dpkg-query"):
        sys.exit(print("No dpkg: the licence texts of system libraries are not collected", file=sys.stderr))
    folder.mkdir(parents=True, exist_ok=True)
    for file in needed_libraries(program) + headers:
        package = package_of(file)
        text = pathlib.Path(f"/usr/share/doc/{package}/copyright")
        if package and text.is_file():
            (folder / f"{package}.txt").write_bytes(text.read_bytes())
        elif "mujoco" not in file:  # its texts come with it
            print(f"no licence text found for {file}", file=sys.stderr)


if __name__ == "__main__":
    main()
