//! What a design is judged for: the loop that it will be in, and what will act on it.

/// What a design is judged for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions<'a> {
    /// Period of the control loop \[s\].
    pub control_period: f64,
    /// Samples from measurement to torque.
    pub delay_samples: usize,
    /// Cut-off of the filter that makes velocities of positions \[Hz\], as
    /// [`Front`](crate::control::Front) has one; `None`: they are measured.
    pub velocity_filter: Option<f64>,
    /// Harmonics of ρ along the reference: amplitude [rad/s²] and frequency [rad/s]. `None`: ρ_d of
    /// the course where the plant is known, 1 rad/s² at 1 rad/s otherwise.
    pub disturbance: Option<&'a [(f64, f64)]>,
    /// Nominal over true inertia: 1 for a right model, 0.5 if the arm is twice as heavy as
    /// believed. With a course its arms count instead.
    pub inertia_ratio: f64,
}

impl Default for Conditions<'_> {
    /// 1 kHz without delay, measured velocities, right inertia.
    fn default() -> Self {
        Self {
            control_period: 1e-3,
            delay_samples: 0,
            velocity_filter: None,
            disturbance: None,
            inertia_ratio: 1.0,
        }
    }
}
