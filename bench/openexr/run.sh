#!/bin/sh
# Renders a small picture with all layers and reads it with OpenEXR's own Python module.
set -eu
cd "$(dirname "$0")/../.."
work=target/openexr
mkdir -p "$work"
[ -x "$work/venv/bin/python" ] || python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet OpenEXR==3.4.4 numpy
cargo run --quiet -- render bench/openexr/scene.toml -q -o "$work/picture.exr" --checkpoint "$work/c.rdf" --resume
"$work/venv/bin/python" bench/openexr/check.py "$work/picture.exr"
