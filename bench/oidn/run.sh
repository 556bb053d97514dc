#!/bin/sh
# Denoises a noisy picture by Rondure's own way and by Intel's Open Image Denoise, whose program comes with a Python package, and compares both with many
# samples. Takes a scene and the size, the still life at 320x240 if not given.
set -eu
cd "$(dirname "$0")/../.."
scene=${1:-scenes/still-life.toml}
size=${2:-320x240}
work=target/oidn
mkdir -p "$work"
[ -x "$work/venv/bin/python" ] || python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --no-deps pyoidn==2.5.1.0
package=$("$work/venv/bin/python" -c 'import importlib.util as u; print(*u.find_spec("pyoidn").submodule_search_locations)')
chmod +x "$package/oidn/bin/oidnDenoise"
PATH="$package/oidn/bin:$PATH"
cargo build --quiet
rondure=target/debug/rondure
"$rondure" render "$scene" --size "$size" --spp 512 --seed 1 -o "$work/reference.exr"
"$rondure" render "$scene" --size "$size" --spp 32 -o "$work/noisy.exr"
"$rondure" denoise "$work/noisy.exr" -o "$work/own.exr"
"$rondure" denoise "$work/noisy.exr" --method oidn -o "$work/oidn.exr"
for name in noisy own oidn; do
    echo "$name"
    "$rondure" compare "$work/$name.exr" "$work/reference.exr"
done
