#!/usr/bin/env python3
"""Puts the package, the executable and all that they need into one file for pip.

Usage: make_wheel.py BUILD_FOLDER OUT_FOLDER

The wheel is an install (bin/takt, lib/takt, share/takt) and the package beside it, out of the build that is there: nothing is
compiled a second time. Shared libraries that a bare system lacks go with it, and find each other by DT_RPATH (patchelf).
Equal builds give equal bytes.
"""
import base64
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
# What every system has (PEP 600), and what belongs to the C library.
SYSTEM = re.compile(r"^(ld-linux-x86-64|lib(c|m|dl|rt|pthread|util|resolv|gcc_s|stdc\+\+))\.so")
PACKAGE = (".py", ".pyi", ".typed")
EPOCH = (2020, 1, 1, 0, 0, 0)
METADATA = """Metadata-Version: 2.1
Name: takt
Version: {version}
Summary: Robot control core and digital twin
Requires-Python: =={python}.*
Requires-Dist: numpy
Provides-Extra: arrow
Requires-Dist: pyarrow; extra == "arrow"
Provides-Extra: gym
Requires-Dist: gymnasium; extra == "gym"
Provides-Extra: plot
Requires-Dist: matplotlib; extra == "plot"
License-File: LICENSE
"""


def call(*arguments):
    return subprocess.run([str(one) for one in arguments], check=True, capture_output=True, text=True).stdout


def version():
    text = (ROOT / "core/base/version.h").read_text()
    return ".".join(re.search(rf"TAKT_VERSION_{part} (\d+)", text).group(1) for part in ("MAJOR", "MINOR", "PATCH"))


def needed_by(file):
    """Paths of the shared libraries that a file loads, those of the system left out."""
    rows = re.findall(r"^\s*(\S+) => (/\S+)", call("ldd", file), re.MULTILINE)
    return {name: pathlib.Path(path).resolve() for name, path in rows if not SYSTEM.match(name)}


def newest_glibc(files):
    """The minor version of glibc that one of them asks for."""
    found = [2]
    for file in files:
        found += [int(one) for one in re.findall(r"\(GLIBC_2\.(\d+)\)", call("objdump", "-T", file))]
    return max(found)


def stage(build, whole, prefix, package):
    """An install (made in `whole`) without what only builds need, the package, and the libraries. Returns the files with
    machine code."""
    call("cmake", "--install", build, "--prefix", whole)
    shutil.copytree(whole / "share", prefix / "share")
    (prefix / "bin").mkdir()
    shutil.copy2(whole / "bin/takt", prefix / "bin/takt")
    shutil.copytree(whole / "lib/takt", prefix / "lib/takt", ignore=shutil.ignore_patterns("*.a"))
    for file in sorted((ROOT / "python/takt").iterdir()):
        if file.suffix in PACKAGE:
            shutil.copy2(file, package / file.name)
    module = next((build / "python/takt").glob("_takt.*.so"))
    shutil.copy2(module, package / module.name)
    libraries = prefix / "lib/takt"
    for name, path in sorted({**needed_by(build / "tools/takt"), **needed_by(module)}.items()):
        if not (libraries / name).exists():
            shutil.copy2(path, libraries / name)
    code = [prefix / "bin/takt", package / module.name, *(one for one in libraries.iterdir() if ".so" in one.name)]
    paths = {prefix / "bin/takt": "$ORIGIN/../lib/takt", package / module.name: "$ORIGIN/../../../takt"}
    for file in code:
        file.chmod(0o755)
        call("strip", "--strip-unneeded", file)
        call("patchelf", "--force-rpath", "--set-rpath", paths.get(file, "$ORIGIN"), file)
    return code


def write(folder, out):
    """Zips it, with the list of hashes that pip checks."""
    info = next(folder.glob("*.dist-info"))
    record = []
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as wheel:
        def add(name, data, executable):
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if executable else 0o100644) << 16
            wheel.writestr(entry, data)
        for file in sorted(one for one in folder.rglob("*") if one.is_file()):
            data, name = file.read_bytes(), str(file.relative_to(folder))
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(data)}")
            add(name, data, file.stat().st_mode & 0o100)
        name = f"{info.name}/RECORD"
        add(name, "\n".join([*record, f"{name},,"]) + "\n", False)


def main(build, out):
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    if not list((build / "python/takt").glob(f"_takt{sysconfig.get_config_var('EXT_SUFFIX')}")):
        raise SystemExit(f"make_wheel: {build}/python has no module for {sys.executable}: build takt_python for it")
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch) / "wheel"
        prefix, package = folder / f"takt-{version()}.data/data", folder / "takt"
        info = folder / f"takt-{version()}.dist-info"
        for one in (prefix, package, info):
            one.mkdir(parents=True)
        glibc = newest_glibc(stage(build, pathlib.Path(scratch) / "install", prefix, package))
        platform = f"manylinux_2_{glibc}_x86_64"
        (info / "METADATA").write_text(METADATA.format(version=version(), python=python))
        (info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: takt\nRoot-Is-Purelib: false\nTag: {tag}-{tag}-{platform}\n")
        shutil.copy2(ROOT / "LICENSE", info / "LICENSE")
        out.mkdir(parents=True, exist_ok=True)
        wheel = out / f"takt-{version()}-{tag}-{tag}-{platform}.whl"
        write(folder, wheel)
    print(wheel)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]))
