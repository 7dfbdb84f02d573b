//! Why a run should not be believed: what its steps were too long for, in words.

use core::fmt;

/// Why a run should not be believed: its step is too long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// The step \[s\].
    pub dt: f64,
    /// When it was worst, or first noticed \[s\].
    pub t: f64,
    /// The joint for which.
    pub joint: usize,
    /// What the step is too long for.
    pub coarse: Coarse,
}

/// What a step is too long for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coarse {
    /// The motion: estimated errors of the position [rad or m].
    Motion {
        /// The largest of one step.
        largest: f64,
        /// The sum over all steps, of the joint for which that is largest.
        sum: f64,
    },
    /// The bounce of a joint in its stop.
    Bounce,
    /// Friction, which was not solved to the end.
    Friction,
    /// Stribeck's friction, which makes the joint break away within a step.
    Falling,
    /// Stiff friction that the controller cancels with a friction law that does not fit the
    /// plant's, for example one of another smoothing.
    Uncovered,
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dt, t, joint, coarse } = self;
        match coarse {
            Coarse::Motion { largest, sum } => write!(
                f,
                "dt = {dt} s is too long for this motion: its steps are off by an estimated \
                 {sum:.1e} rad in sum, \
                 and by up to {largest:.1e} rad each (q[{joint}] at t = {t:.6} s)"
            ),
            Coarse::Bounce => write!(
                f,
                "dt = {dt} s is too long for the stop of q[{joint}], which it met at t = {t:.6} \
                 s: the bounce is \
                 shorter than a step"
            ),
            Coarse::Falling => write!(
                f,
                "dt = {dt} s is too long for the friction of q[{joint}], which breaks away within \
                 a step \
                 (from t = {t:.6} s on)"
            ),
            Coarse::Uncovered => write!(
                f,
                "dt = {dt} s is too long for the friction that the controller adds for \
                 q[{joint}]: it is no part of \
                 the plant's (larger, or with another smoothing), and too stiff from t = {t:.6} s \
                 on"
            ),
            Coarse::Friction => write!(
                f,
                "dt = {dt} s is too long: friction and stops at t = {t:.6} s were not solved to \
                 the end"
            ),
        }?;
        f.write_str("; use a smaller dt")
    }
}
