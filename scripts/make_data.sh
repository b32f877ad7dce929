#!/bin/sh
# Makes data/bal again with raylign's own generator: ./scripts/make_data.sh [target folder]
# Needs `raylign` on PATH. Each command is printed; data/README.md says what the files are.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${1:-"$root/data/bal"}
mkdir -p "$target"
cd "$target"
set -x

raylign synthetic bal -q -o street.txt.gz --truth street-truth.txt.gz --kind street --seed 2026 \
  --num-cameras 48 --num-points 4500 --views-per-stop 2 --mean-track-length 8 --focal 380 \
  --loop-closure-fraction 0.6 --pixel-noise 0.5 --outlier-fraction 0.02 \
  --translation-noise 0.04 --point-noise 0.04

raylign synthetic bal -q -o orbit.txt.gz --truth orbit-truth.txt.gz --kind orbit --seed 2026 \
  --num-cameras 32 --num-points 3000 --mean-track-length 4.5 --pixel-noise 0.6

raylign synthetic bal -q -o tiny.txt --truth tiny-truth.txt --kind orbit --seed 1 \
  --num-cameras 3 --num-points 20 --mean-track-length 2.5 --pixel-noise 0.5
