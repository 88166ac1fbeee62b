#!/usr/bin/env bash
# What a build from nothing costs: CPU and wall time of the program, of the tests and benchmarks on top of it, and of the
# fuzz programs. Builds in a temporary folder, without the compiler's cache; nothing of build/ is used or changed.
#   bench/build_time.sh [JOBS] [program|tests|fuzz]    default: all processors, all three
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
jobs=${1:-$(nproc)}
last=${2:-fuzz}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
all_cpu=0

# measured NAME COMMAND...: runs it quietly and prints what it took, and the CPU time up to here.
measured() {
  local name=$1 wall user system
  shift
  local TIMEFORMAT='%R %U %S'
  # shellcheck disable=SC2034
  read -r wall user system < <({ time "$@" >"$folder/log" 2>&1 || echo failed >"$folder/failed"; } 2>&1 | tail -n 1)
  if [ -e "$folder/failed" ]; then
    tail -n 50 "$folder/log" >&2
    exit 1
  fi
  all_cpu=$(awk "BEGIN { print $all_cpu + $user + $system }")
  awk "BEGIN { printf \"%-22s %5.1f min CPU  %5.1f min wall  %5.1f min CPU up to here\\n\", \"$name\",
       ($user + $system) / 60, $wall / 60, $all_cpu / 60 }"
}

program() {
  cmake -S "$root" --preset release -B "$folder/build" -DTAKT_CCACHE=OFF -DTAKT_CLANG=OFF
  cmake --build "$folder/build" -j "$jobs" --target takt
}
fuzz() {
  cmake -S "$root" --preset fuzz -B "$folder/fuzz" -DTAKT_CCACHE=OFF
  cmake --build "$folder/fuzz" -j "$jobs" --target fuzz_net fuzz_urdf fuzz_device
}

cd "$root"
measured program program
if [ "$last" != program ]; then measured "tests and benchmarks" cmake --build "$folder/build" -j "$jobs"; fi
if [ "$last" = fuzz ]; then measured "fuzz programs" fuzz; fi
