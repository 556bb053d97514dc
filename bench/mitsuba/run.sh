#!/usr/bin/env bash
# Renders three scenes with Rondure and with Mitsuba 3, which it installs into target/mitsuba from the Python Package
# Index, compares the pictures, and prints the speed of both. Options: bench/mitsuba/run.sh --help
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
work=target/mitsuba
mkdir -p "$work"
[ -x "$work/venv/bin/python" ] || python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet mitsuba==3.9.1 numpy pillow
# Mitsuba's LLVM variants want a libLLVM of version 16 or later; that of the Rust compiler will do.
: "${DRJIT_LIBLLVM_PATH:=$(find "$(rustc --print sysroot)/lib" -maxdepth 1 -name 'libLLVM.so.*' | head -n 1)}"
export DRJIT_LIBLLVM_PATH
cargo build --quiet --release -p rondure-cli
cargo build --quiet --release -p rondure --example mesh
exec "$work/venv/bin/python" bench/mitsuba/compare.py --binaries "${CARGO_TARGET_DIR:-target}/release" --work "$work" "$@"
