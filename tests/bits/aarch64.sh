#!/bin/sh
# The golden bits of AArch64, emulated: in Debian's packages gcc-aarch64-linux-gnu,
# libc6-dev-arm64-cross and qemu-user, and `rustup target add aarch64-unknown-linux-gnu`.
set -eu
cd "$(dirname "$0")"
target="${CARGO_TARGET_DIR:-../../target}/bits"
triple=aarch64-unknown-linux-gnu

for tool in aarch64-linux-gnu-gcc qemu-aarch64; do
    command -v "$tool" >/dev/null || { echo "AArch64: no $tool here; see $0"; exit; }
done
[ -d "$(rustc --print sysroot)/lib/rustlib/$triple" ] || {
    echo "AArch64: no standard library of $triple here; see $0"
    exit
}

echo "golden bits, built for $triple, in qemu-aarch64"
CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu" \
    "${CARGO:-cargo}" test --quiet --locked --release --target "$triple" \
    --target-dir "$target/$triple"
