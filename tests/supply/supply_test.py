#!/usr/bin/env python3
"""What takt takes from others (third_party/): archives, the tests' Python packages, licences, names of temporary files.

Usage: supply_test.py BUILD_FOLDER
"""
import hashlib
import http.server
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
FETCH = ROOT / "third_party/fetch_archive.py"
CONTENT = b"an archive, so to speak"
FILE = "some_thing-1.2.tar.gz"


def sha256(content):
    return hashlib.sha256(content).hexdigest()


class Index:
    """A package index on this machine with one file; `stated` is the hash that its page states."""

    def __init__(self, content=CONTENT, stated=None):
        stated = stated or sha256(content)
        pages = {"/simple/some-thing/": (b'<a href="../../files/%s#sha256=%s">f</a>' % (FILE.encode(), stated.encode()),
                                         "text/html"),
                 f"/files/{FILE}": (content, "application/gzip")}
        self.asked = asked = []

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                asked.append(self.path)
                if self.path not in pages:
                    return self.send_error(404)
                content, kind = pages[self.path]
                self.send_response(200)
                self.send_header("Content-Type", kind)
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{self.server.server_port}/simple"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


class Archive(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.list = pathlib.Path(folder.name) / "some.txt"
        self.list.write_text(f"some-thing==1.2 --hash=sha256:{sha256(CONTENT)}\n")
        self.cache = pathlib.Path(folder.name) / "cache"

    def fetch(self, index):
        environment = {**os.environ, "PIP_INDEX_URL": index.url, "no_proxy": "127.0.0.1"}
        return subprocess.run([sys.executable, "-B", FETCH, self.list, self.cache], env=environment, capture_output=True,
                              text=True, check=False)

    def put(self, content):
        self.cache.mkdir()
        (self.cache / FILE).write_bytes(content)

    def test_it_is_fetched_once(self):
        with Index() as index:
            first = self.fetch(index)
            self.assertEqual(first.returncode, 0, first.stderr)
            self.assertEqual(pathlib.Path(first.stdout.strip()).read_bytes(), CONTENT)
            self.assertEqual(len(index.asked), 2)
            self.assertEqual(self.fetch(index).stdout, first.stdout)
            self.assertEqual(len(index.asked), 2, "what is in the cache needs no network")

    def test_a_changed_archive_in_the_cache_is_not_used(self):
        self.put(CONTENT + b"!")
        with Index() as index:
            done = self.fetch(index)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("is not the archive that is pinned", done.stderr)
        self.assertEqual((self.cache / FILE).read_bytes(), CONTENT)

    def test_a_changed_archive_in_the_cache_is_not_used_without_network_either(self):
        self.put(CONTENT + b"!")
        with Index(CONTENT + b"!") as index:
            done = self.fetch(index)
        self.assertEqual(done.returncode, 1)
        self.assertIn("has no file of some-thing with SHA-256", done.stderr)
        self.assertEqual(list(self.cache.iterdir()), [])

    def test_an_index_that_states_the_right_hash_and_gives_something_else_is_refused(self):
        with Index(CONTENT + b"!", stated=sha256(CONTENT)) as index:
            done = self.fetch(index)
        self.assertEqual(done.returncode, 1)
        self.assertIn("is not what was pinned", done.stderr)
        self.assertEqual(list(self.cache.iterdir()), [], "nothing is left behind")

    def test_a_list_without_hash_is_refused(self):
        self.list.write_text("some-thing==1.2\n")
        with Index() as index:
            done = self.fetch(index)
            self.assertEqual(index.asked, [])
        self.assertEqual(done.returncode, 1)
        self.assertIn("--hash=sha256", done.stderr)


class Lists(unittest.TestCase):
    def test_everything_is_pinned_by_hash(self):
        for name in ("third_party/mujoco.txt", "third_party/ruckig.txt", "tests/requirements.txt"):
            lines = [line for line in (ROOT / name).read_text().split("\n") if line and not line.startswith("#")]
            self.assertTrue(lines)
            for line in lines:
                self.assertRegex(line, r"^[A-Za-z0-9._-]+==\S+ --hash=sha256:[0-9a-f]{64}$", name)

    def test_pip_installs_nothing_else(self):
        """With --require-hashes pip refuses whatever a package needs beyond the list, and a wheel runs no code."""
        calls = [line for line in (ROOT / "takt").read_text().split("\n") if "/bin/pip" in line]
        self.assertEqual(len(calls), 1)
        self.assertIn("--require-hashes --only-binary=:all:", calls[0])

    def test_no_build_file_lets_pip_download(self):
        for file in [*ROOT.glob("cmake/*"), ROOT / "CMakeLists.txt"]:
            self.assertNotRegex(file.read_text(), r"pip (download|install|wheel)", str(file))


class TemporaryFiles(unittest.TestCase):
    """A name that can be guessed can be taken by somebody else: mkstemp and mkdtemp make names that cannot."""

    def test_names_are_not_made_of_process_numbers(self):
        files = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "*.cc", "*.h"], cwd=ROOT,
                               capture_output=True, text=True, check=True).stdout.split()
        self.assertTrue(files)
        guessed = re.compile(r"(?:to_string|format)\([^;]*\bgetpid\(|\btmpnam\(|\btempnam\(|temp_directory_path\(\) / \"[^\"]*(?<!XXXXXX)\"\)?;")
        found = [name for name in files if (ROOT / name).is_file() and guessed.search((ROOT / name).read_text())]
        self.assertEqual(found, [])


@unittest.skipUnless((BUILD / "tools/takt").exists(), "a build without the program installs none")
class Licences(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        prefix = pathlib.Path(cls.folder.name)
        subprocess.run(["cmake", "--install", BUILD, "--prefix", prefix], check=True, capture_output=True)
        cls.program = prefix / "bin/takt"
        cls.licences = prefix / "share/takt/licenses"

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def text(self, name):
        return (self.licences / name).read_text()

    def test_what_is_copied_and_compiled_in_has_its_text(self):
        self.assertIn("Apache License", self.text("mujoco/LICENSE"))
        self.assertIn("MIT License", self.text("ruckig/LICENSE"))
        for package in ("libeigen3-dev", "nlohmann-json3-dev", "libcli11-dev"):
            self.assertIn("opyright", self.text(f"debian/{package}.txt"))

    @unittest.skipUnless(shutil.which("dpkg-query"), "other systems list their files otherwise")
    def test_what_is_linked_has_its_text(self):
        wanted = subprocess.run(["readelf", "--dynamic", "--wide", self.program], capture_output=True, text=True, check=True)
        libraries = re.findall(r"\(NEEDED\).*\[lib([a-z_A-Z]+)", wanted.stdout)
        self.assertIn("protobuf", libraries)
        words = {"stdc": "libstdc++6", "gcc_s": "libgcc-s1", "c": "libc6", "m": "libc6", "z": "zlib1g"}
        present = {path.stem for path in (self.licences / "debian").iterdir()}
        for library in libraries:
            name = words.get(library, "lib" + library.lower().replace("_", "-"))
            if library != "mujoco":
                self.assertTrue(any(package.startswith(name) for package in present), f"{library}: {sorted(present)}")


if __name__ == "__main__":
    unittest.main()
