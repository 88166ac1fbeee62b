#!/usr/bin/env bash
# Builds the page into panel/dist, if it is not up to date. Without Node.js and npm, or without a way to the packages,
# it says so and ends well: everything but the page works without them. Usage: build.sh [--required]
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")"

say() { printf 'takt: %s\n' "$*" >&2; }
missing() {
  say "the page of 'takt serve' and 'takt run --panel' is not built: $*"
  exit "$status"
}
status=0
if [ "${1:-}" = --required ]; then status=1; fi

if [ -f dist/index.html ] && [ -z "$(find src index.html icon.svg build.mjs package-lock.json -newer dist/index.html -type f -print -quit)" ]; then
  exit 0
fi
command -v node >/dev/null || missing "Node.js is not installed (apt-get install nodejs npm)"
command -v npm >/dev/null || missing "npm is not installed (apt-get install nodejs npm)"
version=$(node --version)
major=${version#v}
if [ "${major%%.*}" -lt 18 ]; then missing "Node.js $version is too old, it takes 18"; fi

# Packages are pinned with their hashes, and none of their own scripts is run.
if [ ! -f node_modules/.package-lock.json ] || [ package-lock.json -nt node_modules/.package-lock.json ]; then
  npm ci --ignore-scripts --no-audit --no-fund --loglevel=error >&2 || missing "npm cannot get its packages"
  touch node_modules/.package-lock.json
fi
node build.mjs >&2
