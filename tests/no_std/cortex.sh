#!/bin/sh
# The steps of main.c on a Cortex-M7, emulated: the torques of this machine, to the bit, within
# limits of stack, memory and instructions. In Debian's packages gcc-arm-none-eabi and
# qemu-system-arm, and `rustup target add thumbv7em-none-eabihf`.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
target=${CARGO_TARGET_DIR:-$here/../../target}
triple=thumbv7em-none-eabihf

for tool in arm-none-eabi-gcc qemu-system-arm; do
    command -v "$tool" >/dev/null || { echo "Cortex-M7: no $tool here; see $0"; exit; }
done
[ -d "$(rustc --print sysroot)/lib/rustlib/$triple" ] || {
    echo "Cortex-M7: no core library of $triple here; see $0"
    exit
}
. "$here/host.sh"

RUSTFLAGS="-C target-cpu=cortex-m7" "${CARGO:-cargo}" build --quiet --locked --release \
    --manifest-path "$here/Cargo.toml" --target "$triple" --target-dir "$build"
arm-none-eabi-gcc -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16 -std=c99 -Wall -Werror \
    -O1 -ffreestanding -nostdlib -Wl,-z,noexecstack -T "$here/cortex.ld" "$here/cortex.c" \
    "$build/$triple/release/libsteadyarm_no_std.a" -lgcc -o "$build/cortex.elf"
found=$(timeout 300 qemu-system-arm -M mps2-an500 -display none -serial none -monitor none \
    -chardev stdio,id=out -semihosting-config enable=on,target=native,chardev=out \
    -icount shift=5,align=off,sleep=off -kernel "$build/cortex.elf" </dev/null)
echo "two joints, 625 rules, on a Cortex-M7 (bytes):"
echo "$found"

# The limits are what was reached, and a little.
echo "$found" | awk -v hash="${without##* }" '
    BEGIN {
        most["build-stack"] = 16384
        most["step-stack"] = 3072
        most["controller"] = 4096
        most["basis"] = 3072
        most["state"] = 768
        most["memory"] = 12288
        most["step-instructions"] = 24000
        most["step-instructions-at-most"] = 36000
    }
    $1 == "hash" { same = $2 == hash }
    $1 in most { seen++ }
    $1 in most && $2 > most[$1] { print "cortex.sh: " $1 ": at most " most[$1]; bad = 1 }
    END {
        if (!same) { print "cortex.sh: the torques are not those of this machine, " hash; bad = 1 }
        if (seen != 8) { print "cortex.sh: something was not measured"; bad = 1 }
        exit bad
    }' >&2
