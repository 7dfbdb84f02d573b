#!/bin/sh
# Links the crate without std into a C program, runs it, and compares its torques with the same
# steps with std.
# Usage: tests/no_std/link.sh (needs cargo and a C compiler; CARGO_TARGET_DIR is respected)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
target=${CARGO_TARGET_DIR:-$here/../../target}
. "$here/host.sh"
echo "without std: $without"

if nm -u "$build/main" | grep -E ' (malloc|calloc|realloc|free|__rust_alloc)'; then
    echo "link.sh: the program refers to an allocator" >&2
    exit 1
fi

with=$(CARGO_TARGET_DIR=$target cargo test --quiet --manifest-path "$here/../../Cargo.toml" \
    --test std_tests no_std_twin -- --nocapture | grep '^torque')
echo "with std:    $with"

if [ "${without##* }" != "${with##* }" ]; then
    echo "link.sh: the torques differ" >&2
    exit 1
fi
