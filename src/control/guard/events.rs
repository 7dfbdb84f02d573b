//! What a guard does about a sample or a torque, each with a name and a count.

/// An intervention of a guard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A position, velocity or set-point is NaN, infinite or impossible: the sample is not used. Or
    /// the torque that is said to have acted is not finite: nothing is learnt from its period.
    NotFinite,
    /// A position is farther from the last one than the speed limit allows, or a velocity is beyond
    /// that limit while the positions are not: the sample is not used.
    Jump,
    /// A sample came less than half a period after the last good one: it is not used.
    Early,
    /// A sample came more than one and a half periods after the last one: it is used, and the
    /// periods in between count as missed.
    Late,
    /// No sample came in a period.
    Missed,
    /// The time since the last sample is not a time that can be: zero, negative, NaN, above 1 s.
    Clock,
    /// The controller refused a good sample, such as for a torque that is NaN.
    Controller,
    /// The effort limit cut the torque.
    Effort,
    /// The limit on the change of the torque cut it.
    EffortRate,
    /// The limit on the mechanical power cut the torque. If it could not be kept, the guard stops.
    /// It holds in every call that brings a velocity; without one, power is not known.
    Power,
    /// A joint is outside its range: the guard stops.
    Position,
    /// A joint is faster than its limit: the guard stops.
    Velocity,
    /// A tracking error left its envelope: the guard stops.
    Envelope,
    /// The caller asked for a stop.
    Stop,
}

impl Event {
    /// All of them, in the order of the counts.
    pub const ALL: [Self; 14] = [
        Self::NotFinite,
        Self::Jump,
        Self::Early,
        Self::Late,
        Self::Missed,
        Self::Clock,
        Self::Controller,
        Self::Effort,
        Self::EffortRate,
        Self::Power,
        Self::Position,
        Self::Velocity,
        Self::Envelope,
        Self::Stop,
    ];

    /// Its name, as in Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::Jump => "jump",
            Self::Early => "early",
            Self::Late => "late",
            Self::Missed => "missed",
            Self::Clock => "clock",
            Self::Controller => "controller",
            Self::Effort => "effort",
            Self::EffortRate => "effort_rate",
            Self::Power => "power",
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Envelope => "envelope",
            Self::Stop => "stop",
        }
    }
}

/// The events of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events(u16);

impl Events {
    /// Adds one.
    pub(super) fn add(&mut self, event: Event) {
        self.0 |= 1 << event as u16;
    }

    /// Adds all of them.
    pub(super) fn join(&mut self, others: Self) {
        self.0 |= others.0;
    }

    /// Whether it is among them.
    pub fn contains(self, event: Event) -> bool {
        self.0 & 1 << event as u16 != 0
    }

    /// Whether nothing happened.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// They, one by one.
    pub fn iter(self) -> impl Iterator<Item = Event> {
        Event::ALL.into_iter().filter(move |&event| self.contains(event))
    }
}

/// Why a guard does what it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cause {
    /// What happened.
    pub event: Event,
    /// The joint; `None` if it is none of one joint.
    pub joint: Option<usize>,
}

impl Cause {
    /// Too many periods without a good sample.
    pub(super) const MISSED: Self = Self { event: Event::Missed, joint: None };
}
