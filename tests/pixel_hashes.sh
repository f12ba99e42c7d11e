#!/usr/bin/env bash
# Hashes of pictures of the bundled scenes, all layers (which hold the pixels of every view mode), on the CPU and on the
# graphics adapter, and of their ray-traced references: environments with and without suns, bounced light by every
# solution, poses, a clip, a ground, thin surfaces, layered and written BRDFs. A change of structure leaves them as they are:
#
#   tests/pixel_hashes.sh BEFORE >before.txt; tests/pixel_hashes.sh AFTER >after.txt; diff before.txt after.txt
#
# BEFORE and AFTER are two builds of `lapidary`. Compare on one machine: libraries of mathematics and drivers differ in
# their last bits. tests/pixel_hashes.txt holds those of 30 November 2026, by Mesa's llvmpipe in Debian on a machine with AVX2.
set -euo pipefail
lapidary=$(realpath "${1:?usage: tests/pixel_hashes.sh LAPIDARY}")
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_RUNTIME_DIR="$work"

small="--preset draft --lights 2048 --max-vertices 4000 --quiet"
"$lapidary" bake data/still-life/still-life.gltf -o "$work/still-life.cuts" $small
"$lapidary" bake data/color-box/color-box.gltf -o "$work/color-box.cuts" $small --mode all --sources 2048 --levels 3
"$lapidary" bake data/interior/interior.gltf -o "$work/interior.cuts" $small --mode all --sources 2048 --levels 3
"$lapidary" bake data/material-study/material-study.gltf -o "$work/study.cuts" $small --ground on
"$lapidary" bake data/bending-tower/bending-tower.gltf -o "$work/tower.cuts" $small

# picture NAME DATASET OPTIONS: on both backends.
picture() {
  local name=$1 dataset=$2 backend samples=(--aa 1)
  shift 2
  [[ " $* " == *" --aa "* ]] && samples=()
  for backend in cpu gpu; do
    "$lapidary" render "$work/$dataset.cuts" --backend $backend --size 160x120 "${samples[@]}" --quiet --layers all "$@" \
      --out "$work/$name-$backend.exr"
  done
}
reference() {
  local name=$1 dataset=$2
  shift 2
  "$lapidary" reference "$work/$dataset.cuts" --size 40x30 --aa 1 --quiet "$@" --out "$work/$name.exr"
}

studio="--env data/environments/studio.hdr"
sky="--env data/environments/sun-and-sky.hdr --rotate 40"
picture still-life-refined still-life $studio --aa 2
picture still-life-once still-life $sky --brdf once --illum-cut 128
picture still-life-ward still-life $studio --material tests/pixel_hashes_ward.json --allow-outside
picture still-life-no-suns still-life $sky --sun off
picture still-life-layers still-life $sky --material Porcelain=tests/pixel_hashes_layers.json --allow-outside
picture still-life-veil still-life $sky --material "Painted canvas=tests/pixel_hashes_veil.json"
picture still-life-velvet still-life $studio --material Linen=tests/pixel_hashes_velvet.json --allow-outside
picture still-life-posed still-life $sky --pose tests/pixel_hashes_bottle.json
for ground in on shadow off; do
  picture "study-ground-$ground" study $sky --ground $ground
done
picture tower-clip tower $sky --animation data/bending-tower/bending-tower.gltf --time 0.5
for solution in cuts meshless cuts+meshless cuts+gloss; do
  picture "color-box-$solution" color-box --env none --solution $solution
  picture "color-box-posed-$solution" color-box --env none --solution $solution --pose tests/pixel_hashes_block.json
  picture "interior-$solution" interior $sky --solution $solution
done
reference still-life-samples still-life $sky --kind samples
reference interior-samples interior $sky --kind samples --components environment,direct,indirect
reference tower-clip-samples tower $sky --kind samples --animation data/bending-tower/bending-tower.gltf --time 0.5
reference still-life-posed-paths still-life $sky --kind path --bounces 2 --spp 4 --pose tests/pixel_hashes_bottle.json
reference interior-paths interior $sky --kind path --bounces 2 --spp 8
reference color-box-paths color-box --env none --kind path --bounces 3 --spp 8

cargo run --release --quiet -p lapidary-interchange --example pixel_hashes -- "$work"/*.exr
