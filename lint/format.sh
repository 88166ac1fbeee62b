#!/usr/bin/env bash
# Checks the layout of all C++ files; `lint/format.sh --fix` mends it.
set -euo pipefail
cd "$(dirname "$0")/.."
mode=(--dry-run -Werror)
if [ "${1:-}" = --fix ]; then mode=(-i); fi
git ls-files -co --exclude-standard -z '*.cc' '*.h' | xargs -0 -r clang-format-14 "${mode[@]}"
