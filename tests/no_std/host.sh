# Sourced: builds the C program with the crate without std for this machine, in $build, and runs it:
# what it prints is in $without.
build=$target/no_std
mkdir -p "$build"
CARGO_TARGET_DIR=$build cargo build --quiet --locked --release --manifest-path "$here/Cargo.toml"
"${CC:-cc}" -std=c99 -Wall -Werror -O1 "$here/main.c" "$build/release/libsteadyarm_no_std.a" -lm \
    -o "$build/main"
without=$("$build/main")
