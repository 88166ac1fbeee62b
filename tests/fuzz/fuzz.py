#!/usr/bin/env python3
"""Runs one fuzz program for a while, from a fixed seed, on a copy of its corpus.

    fuzz.py PROGRAM CORPUS SCRATCH [SECONDS [PATTERN...]]

Files that fit one of the patterns begin with those of the corpus: what a project has by the dozen is not kept twice.
TAKT_FUZZ_SECONDS goes before SECONDS (3600 for an evening), TAKT_SEED before the seed 1. What crashes, hangs (more than
20 s for one input, checks included) or takes more than 1 GiB lies in SCRATCH/found and is printed in Base64. Exit
status 1 then. To see one again: PROGRAM FILE.
"""
import os
import pathlib
import shutil
import subprocess
import sys

MOST_BYTES = 16384  # per input: the limit of files is tried by tests of core/base, here it would only be slow
MOST_MEMORY_MIB = 1024
MOST_SECONDS_PER_INPUT = 20


def main():
    program, corpus, scratch = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    seconds = os.environ.get("TAKT_FUZZ_SECONDS", sys.argv[4] if len(sys.argv) > 4 else "60")
    seed = os.environ.get("TAKT_SEED", "1")
    shutil.rmtree(scratch, ignore_errors=True)
    (scratch / "corpus").mkdir(parents=True)
    (scratch / "found").mkdir()
    (scratch / "begin").mkdir()
    for pattern in sys.argv[5:]:
        for path in sorted(pathlib.Path(".").glob(pattern)):
            shutil.copy(path, scratch / "begin" / "-".join(path.parts))
    command = [program, f"-seed={seed}", f"-max_total_time={seconds}", f"-max_len={MOST_BYTES}",
               f"-rss_limit_mb={MOST_MEMORY_MIB}", f"-timeout={MOST_SECONDS_PER_INPUT}", "-print_final_stats=1",
               f"-artifact_prefix={scratch}/found/"]
    words = subprocess.run([program, "--dictionary"], capture_output=True, text=True, check=True).stdout
    if words:
        (scratch / "words.dict").write_text(words)
        command.append(f"-dict={scratch}/words.dict")
    # The first folder takes what is found on the way, the second is only read.
    result = subprocess.run(command + [str(scratch / "corpus"), str(scratch / "begin"), str(corpus)], capture_output=True, text=True,
                            errors="replace")
    lines = result.stderr.split("\n")
    shown = lines if result.returncode else [line for line in lines if line.startswith(("stat::", "Done"))]
    print("\n".join(shown[-200:]))
    found = sorted((scratch / "found").iterdir())
    for path in found:
        print(f"found: {path}")
    return 1 if result.returncode or found else 0


if __name__ == "__main__":
    sys.exit(main())
