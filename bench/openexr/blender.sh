#!/bin/sh
# Renders a small picture with all layers and reads it with Blender, as a Python module of 350 MB.
set -eu
cd "$(dirname "$0")/../.."
work=target/openexr
mkdir -p "$work"
[ -x "$work/blender/bin/python" ] || python3.11 -m venv "$work/blender"
"$work/blender/bin/pip" install --quiet bpy==4.5.15 numpy
cargo run --quiet -- render bench/openexr/scene.toml -q -o "$work/picture.exr" --checkpoint "$work/c.rdf" --resume
"$work/blender/bin/python" bench/openexr/blender.py "$work/picture.exr"
