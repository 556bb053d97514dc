#!/usr/bin/env bash
# Renders the still life with Rondure and with POV-Ray 3.7, which it installs on Debian if it is
# missing, and prints both times and their ratio. Options: bench/povray/run.sh --help
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
cargo build --release --quiet -p rondure-cli -p bench-povray
exec "${CARGO_TARGET_DIR:-target}/release/bench-povray" "$@"
