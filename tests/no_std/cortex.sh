#!/bin/sh
# The steps of main.c on a Cortex-M7, and those of single.h on a Cortex-M4F, emulated: the torques of
# this machine, to the bit, within limits of stack, memory and instructions. In Debian's packages
# gcc-arm-none-eabi, libnewlib-arm-none-eabi and qemu-system-arm, and `rustup target add
# thumbv7em-none-eabihf`.
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

# emulated PROCESSOR FPU BOARD PROGRAM FEATURES: builds the program for this processor, and runs it.
emulated() {
    RUSTFLAGS="-C target-cpu=$1" "${CARGO:-cargo}" build --quiet --locked --release \
        --features "$5" --manifest-path "$here/Cargo.toml" --target "$triple" \
        --target-dir "$build/$1"
    arm-none-eabi-gcc -mcpu="$1" -mthumb -mfloat-abi=hard -mfpu="$2" -std=c99 -Wall -Werror \
        -O1 -ffreestanding -nostdlib -Wl,-z,noexecstack -T "$here/cortex.ld" "$here/$4.c" \
        "$build/$1/$triple/release/libsteadyarm_no_std.a" -lgcc -o "$build/$4.elf"
    timeout 300 qemu-system-arm -M "$3" -display none -serial none -monitor none \
        -chardev stdio,id=out -semihosting-config enable=on,target=native,chardev=out \
        -icount shift=5,align=off,sleep=off -kernel "$build/$4.elf" </dev/null
}

# check NAME...: reads "name number" lines; each of these pairs NAME=LIMIT must be there, and not
# above. The limits are what was reached, and a little.
check() {
    awk -v limits="$*" '
        BEGIN {
            count = split(limits, pairs, " ")
            for (i = 1; i <= count; i++) {
                split(pairs[i], pair, "=")
                most[pair[1]] = pair[2]
            }
        }
        $1 in most { seen++ }
        $1 in most && $2 > most[$1] { print "cortex.sh: " $1 ": at most " most[$1]; bad = 1 }
        END {
            if (seen != count) { print "cortex.sh: something was not measured"; bad = 1 }
            exit bad
        }' >&2
}

found=$(emulated cortex-m7 fpv5-d16 mps2-an500 cortex "")
echo "two joints, 625 rules, on a Cortex-M7 (bytes):"
echo "$found"

[ "$(echo "$found" | awk '$1 == "hash" { print $2 }')" = "${without##* }" ] || {
    echo "cortex.sh: the torques are not those of this machine, ${without##* }" >&2
    exit 1
}
echo "$found" | check build-stack=16384 step-stack=3072 controller=4096 basis=3072 state=768 \
    memory=12288 step-instructions=24000 step-instructions-at-most=36000

CARGO_TARGET_DIR=$build/host "${CARGO:-cargo}" build --quiet --locked --release --features single \
    --manifest-path "$here/Cargo.toml"
"${CC:-cc}" -std=c99 -Wall -Werror -O1 "$here/single_host.c" \
    "$build/host/release/libsteadyarm_no_std.a" -lm -o "$build/single_host"
found=$(emulated cortex-m4 fpv4-sp-d16 mps2-an386 single single)
echo "25 rules a joint in single precision, on a Cortex-M4F (bytes of stack):"
echo "$found"
[ "$(echo "$found" | grep bits)" = "$("$build/single_host")" ] || {
    echo "cortex.sh: the torques in single precision are not those of this machine" >&2
    exit 1
}
echo "$found" | check two-link-instructions=4800 two-link-instructions-at-most=4800 \
    two-link-stack=1024 panda-instructions=23000 panda-instructions-at-most=23000 panda-stack=3328
