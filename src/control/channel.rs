//! What a recorded signal is: a name, a unit, a width, a line of words.

/// A recorded signal. Its maker declares it in one place; record, files and Python take it from
/// there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name in code and in files: a word of letters, digits and underscores.
    pub name: &'static str,
    /// Unit, `1` for a number without one. rad stands for m, and N·m for N, at a prismatic joint.
    pub unit: &'static str,
    /// Numbers in a row.
    pub width: Width,
    /// What it is, without a full stop.
    pub doc: &'static str,
}

/// Numbers in a row of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// One.
    One,
    /// One per joint.
    Joints,
}

impl Width {
    /// Numbers in a row, for so many joints.
    pub const fn of(self, joints: usize) -> usize {
        match self {
            Self::One => 1,
            Self::Joints => joints,
        }
    }
}
