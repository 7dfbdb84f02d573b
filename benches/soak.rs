//! A long run of the guarded loop with faults, with a line of a log every 1e8 steps; not a
//! measurement of speed.
//!
//! `cargo bench --bench soak -- 1e9` runs that many steps; without a number it runs 1e7.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::env::args;
use std::time::Instant;

use soak::Soak;

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/soak.rs"]
mod soak;

const LINE: u64 = 100_000_000;

fn main() {
    let asked = args().find_map(|word| word.parse::<f64>().ok()).unwrap_or(1e7);
    let (mut left, mut soak, start) = (asked as u64, Soak::new(1), Instant::now());
    while left > 0 {
        let steps = left.min(LINE);
        soak.run(steps);
        left -= steps;
        println!("{:.0} s: {soak}", start.elapsed().as_secs_f64());
    }
}
