"""python3 -m takt sweep ...: verbs in Python (docs/sweeps.md). All others are those of the executable `takt`."""
import sys

from . import sweeps

VERBS = {"sweep": sweeps.main}

if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] not in VERBS:
        raise SystemExit(f"{__doc__}\nUsage: python3 -m takt {'|'.join(VERBS)} ...")
    raise SystemExit(VERBS[sys.argv[1]](sys.argv[2:]))
