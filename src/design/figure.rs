//! Numbers in words for people.

use core::fmt;

/// A number to read: three digits, and a power of ten where that is shorter.
pub(super) struct Figure(pub f64);

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(x) = *self;
        match x.abs() {
            0.0 => f.write_str("0"),
            size if (100.0..1e5).contains(&size) => write!(f, "{x:.0}"),
            size if (10.0..100.0).contains(&size) => write!(f, "{x:.1}"),
            size if (1.0..10.0).contains(&size) => write!(f, "{x:.2}"),
            size if (1e-3..1.0).contains(&size) => write!(f, "{x:.3}"),
            _ => write!(f, "{x:.1e}"),
        }
    }
}
