#!/usr/bin/env python3
"""Fetches the one archive that a requirement file pins ("name==version --hash=sha256:...") and prints its path.

Usage: fetch_archive.py REQUIREMENT_FILE FOLDER

The archive is kept in FOLDER. It is checked against the hash each time: when it comes from the network and when it is
already there; one that is not what was pinned is fetched again. Nothing of it is run. The package index is the one that
pip is configured for (pip.conf, PIP_INDEX_URL, else pip's own). Exit status 1 and a reason if there is no such archive.
"""
import hashlib
import html.parser
import json
import os
import pathlib
import re
import ssl
import subprocess
import sys
import tempfile
import urllib.error
import urllib.parse
import urllib.request

PINNED = re.compile(r"^([A-Za-z0-9._-]+)==(\S+) --hash=sha256:([0-9a-f]{64})$", re.MULTILINE)
JSON = "application/vnd.pypi.simple.v1+json"
TIMEOUT = 60  # s without a byte
RETRIES = 3


class Refused(Exception):
    """Why there is no archive."""


def read_pin(file):
    pins = PINNED.findall(pathlib.Path(file).read_text())
    if len(pins) != 1:
        raise Refused(f"{file}: one line 'name==version --hash=sha256:...' is expected")
    return pins[0]


def hash_of(path):
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def cached(folder, name, version, pinned):
    """The archive in the folder, or None. Files of this version that are not what was pinned are removed."""
    found = None
    for path in sorted(folder.iterdir()):
        stem = re.sub(r"[-_.]+", "-", path.name).lower()
        if not stem.startswith(re.sub(r"[-_.]+", "-", f"{name}-{version}-").lower()):
            continue
        if hash_of(path) == pinned:
            found = path
        else:
            print(f"{path} is not the archive that is pinned (SHA-256 differs): removed", file=sys.stderr)
            path.unlink()
    return found


def index_url():
    """pip's help shows its settings as defaults."""
    text = subprocess.run([sys.executable, "-m", "pip", "download", "--help"], capture_output=True, text=True, check=False,
                          env={**os.environ, "COLUMNS": "1000"}).stdout
    match = re.search(r"--index-url\s+<url>[^(]*\(default\s+([^)\s]+)\)", re.sub(r"\s+", " ", text))
    if not match:
        raise Refused("pip names no package index. Is python3-pip installed?")
    return match.group(1)


def get(url, accept="*/*"):
    request = urllib.request.Request(url, headers={"Accept": accept, "User-Agent": "takt"})
    certificates = os.environ.get("PIP_CERT") or os.environ.get("SSL_CERT_FILE")
    context = ssl.create_default_context(cafile=certificates)
    for attempt in range(RETRIES):
        try:
            with urllib.request.urlopen(request, timeout=TIMEOUT, context=context) as answer:
                return answer.read(), answer.headers.get_content_type(), answer.url
        except urllib.error.HTTPError:
            raise
        except OSError:
            if attempt == RETRIES - 1:
                raise
    raise AssertionError("unreachable")


class Links(html.parser.HTMLParser):
    """The links of an index page without JSON (PEP 503)."""

    def __init__(self):
        super().__init__()
        self.links = []

    def handle_starttag(self, tag, attrs):
        self.links += [value for key, value in attrs if tag == "a" and key == "href" and value]


def files_of(page, kind, base):
    """(URL, hash) of all files on an index page; None where the page states no hash."""
    if kind == JSON:
        for file in json.loads(page)["files"]:
            yield urllib.parse.urljoin(base, file["url"]), file["hashes"].get("sha256")
        return
    parser = Links()
    parser.feed(page.decode())
    for link in parser.links:
        url, fragment = urllib.parse.urldefrag(urllib.parse.urljoin(base, link))
        yield url, fragment.removeprefix("sha256=") if fragment.startswith("sha256=") else None


def find(name, pinned):
    page, kind, base = get(f"{index_url().rstrip('/')}/{re.sub(r'[-_.]+', '-', name).lower()}/", f"{JSON}, text/html;q=0.1")
    for url, stated in files_of(page, kind, base):
        if stated == pinned:
            return url
    raise Refused(f"the package index has no file of {name} with SHA-256 {pinned}")


def fetch(folder, name, pinned):
    url = find(name, pinned)
    content, _, _ = get(url)
    if hashlib.sha256(content).hexdigest() != pinned:
        raise Refused(f"what the package index gives for {name} is not what was pinned: SHA-256 differs")
    handle, temporary = tempfile.mkstemp(dir=folder, prefix=".fetch-")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        path = folder / urllib.parse.unquote(pathlib.PurePosixPath(urllib.parse.urlparse(url).path).name)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
    return path


def main():
    name, version, pinned = read_pin(sys.argv[1])
    folder = pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    print(cached(folder, name, version, pinned) or fetch(folder, name, pinned))


if __name__ == "__main__":
    try:
        main()
    except (Refused, OSError, ValueError) as error:
        sys.exit(f"fetch_archive: {error}")
