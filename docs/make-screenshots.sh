#!/bin/sh
# Makes the screenshots of docs/inspector.md: the real inspector with real scenes, without a display.
set -eu
cd "$(dirname "$0")/.."
cargo build --release --locked
out=docs/images/inspector
mkdir -p "$out"

shot() {
    name=$1
    shift
    ./target/release/raystep inspect "$@" --screenshot "$out/$name.png"
}

box="scenes/cornell-box.gltf --size 256x256 --pixel 96,180"
shot first scenes/cornell-box.gltf --window 1280x760
shot ../walk scenes/cornell-box.gltf --grid 5 --pixel 360,180 --window 1080x440 --scale 1.5 --do "Toolbar words" \
    --do "Maximise panel" --do "Unfolded walk" --do "Toggle light/dark theme"
shot step $box --pass 35 --window 1600x1000 --do "Step layout"
shot walk $box --pass 35 --window 1600x900 --do "Ray layout" --do "Kernel"
shot tree scenes/teapot.glb --size 256x256 --accelerator bvh --pass 60 --window 1600x1000 --do "Ray layout"
shot tests scenes/sphere-flake.glb --size 256x256 --window 1280x760 --do "Ray layout" --do "Colour 3D view by cost"
shot compare scenes/teapot.glb --size 256x256 --window 1500x760 --do "Compare layout" --do "Compare with BVH"
shot runs docs/cornell-box.raystep-session --window 1600x900 --do "Run kept runs again" --do "Runs"
shot divergence scenes/terrain.glb --size 256x256 --window 1280x760 --do "Map GPU/CPU differences" --do "Maximise panel"
shot error scenes/cornell-box.gltf --numerics paper --grid 20 --window 1000x600 --do "Judge hits"
shot cost scenes/terrain.glb --size 256x256 --window 1280x800 --do "Cost layout"
shot structure scenes/sphere-flake.glb --size 256x256 --window 1280x760 --do "Grid and BVH"
shot timings scenes/terrain.glb --size 256x256 --window 1280x760 --do "Timings"
shot dataflow $box --pass 35 --window 1280x760 --do "Data flow" --do "Maximise panel"
shot plan $box --window 1280x760 --do "Plan" --do "Toggle light/dark theme"
shot lesson --lesson one-ray --step 5 --window 1280x760
shot texels --link "raystep:1?scene=scenes/cornell-box.gltf&size=256x256&pixel=96,180&pass=35&stream=state&zoom=96&pan=96,180" \
    --window 1280x760
