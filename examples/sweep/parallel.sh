#!/bin/sh
# Runs the lines of a list, two at a time, with GNU parallel where it is installed and with xargs elsewhere.
#   ./parallel.sh sweep/jobs.txt
set -eu
if command -v parallel >/dev/null; then
    exec parallel --jobs 2 <"$1"
fi
tr '\n' '\0' <"$1" | xargs -0 -n 1 -P 2 sh -c
