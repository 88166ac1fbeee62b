#!/usr/bin/env bash
# The gate's part of the tests of the page. Usage: run.sh TAKT
set -euo pipefail
panel/build.sh --required
TAKT=$1 exec node --test tests/panel/panel.test.mjs
