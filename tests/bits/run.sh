#!/bin/sh
# The golden bits in builds for x86-64-v3 and v4, as far as this processor runs them. For x86-64-v1 all tests of the
# crate are built, and these are among them.
set -eu
cd "$(dirname "$0")"
target="${CARGO_TARGET_DIR:-../../target}/bits"

run() {
    echo "golden bits, built for $1"
    RUSTFLAGS="-C target-cpu=$1" "${CARGO:-cargo}" test --quiet --locked --release --target-dir "$target/$1"
}

has() {
    grep -qw "$1" /proc/cpuinfo 2>/dev/null
}

if [ "$(uname -m)" != x86_64 ]; then
    run generic
    exit
fi
if has avx2 && has fma && has bmi2; then run x86-64-v3; else echo "x86-64-v3: not on this processor"; fi
if has avx512f && has avx512vl; then run x86-64-v4; else echo "x86-64-v4: not on this processor"; fi
