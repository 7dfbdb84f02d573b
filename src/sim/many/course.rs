//! How far runs that go side by side go.

use core::sync::atomic::{AtomicBool, Ordering};

use super::bodies::Bodies;

/// A run that diverges, or is to end, is looked for once in so many steps.
const LOOK_EVERY: usize = 256;

/// How far runs go, and which rows count.
#[derive(Clone, Copy)]
pub(super) struct Course<'a> {
    /// Steps, and the length of each \[s\].
    pub steps: usize,
    pub h: f64,
    /// Steps in a period of a sampled controller.
    pub hold: usize,
    /// Rows that count are so many steps apart.
    pub every: usize,
    pub stop: &'a AtomicBool,
}

impl Course<'_> {
    /// Whether row k counts.
    pub fn counts(&self, k: usize) -> bool {
        k.is_multiple_of(self.every) || k == self.steps
    }

    /// Whether there is nothing left to do after row k.
    pub fn ends<const N: usize>(&self, k: usize, bodies: &Bodies<N>) -> bool {
        k.is_multiple_of(LOOK_EVERY) && (self.stop.load(Ordering::Relaxed) || !bodies.goes_on())
    }
}
