//! Arms from an arm: with other friction, rotors, stops, gravity or inertial parameters, or with a
//! payload.

use super::inertia::PER_LINK;
use super::place::InertiaNames;
use super::{Inertia, JointStop, Pose, Serial, SerialParameters, Unphysical, joint};
use crate::arm::JointFriction;
use crate::error::{Result, finite, length};

const PAYLOAD: InertiaNames =
    InertiaNames { mass: "payload.mass", com: "payload.com", moments: "payload.moments" };

impl<const N: usize> Serial<N> {
    /// The same arm with no friction in any joint.
    #[must_use]
    pub fn without_friction(&self) -> Self {
        let mut arm = *self;
        for joint in 0..N {
            arm.parameters.links[joint].friction = JointFriction::default();
            arm.chain.joints[joint].friction = JointFriction::default();
        }
        (arm.has_friction, arm.sticks) = (false, false);
        arm
    }

    /// The same arm with this friction in place of its own.
    ///
    /// # Errors
    /// As [`JointFriction::validate`].
    pub fn with_friction(&self, friction: &[JointFriction; N]) -> Result<Self> {
        let mut parameters = self.parameters;
        for (link, friction) in parameters.links.iter_mut().zip(friction) {
            link.friction = *friction;
        }
        self.rebuilt(parameters)
    }

    /// The same arm with rotors of this inertia in place of its own, seen through the gears
    /// [kg·m² or kg].
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `armature`; `inertia` if a joint moves no mass and has
    /// no rotor.
    pub fn with_armature(&self, armature: &[f64; N]) -> Result<Self> {
        let mut parameters = self.parameters;
        for (link, armature) in parameters.links.iter_mut().zip(armature) {
            link.armature = *armature;
        }
        self.rebuilt(parameters)
    }

    /// The same arm under another gravity, in the axes of the base [m/s²].
    ///
    /// # Errors
    /// `NotFinite`, naming `gravity`.
    pub fn with_gravity(&self, gravity: [f64; 3]) -> Result<Self> {
        self.rebuilt(SerialParameters { gravity, ..self.parameters })
    }

    /// The same arm with the inertial parameters π, 10 a link: the way back from
    /// [`inertial_parameters`](Self::inertial_parameters), and the same to rounding.
    ///
    /// # Errors
    /// `WrongLength` or `NotFinite`, naming `parameters`; as [`Serial::new_with`] for links that no
    /// rigid body can be.
    pub fn with_parameters(&self, parameters: &[f64]) -> Result<Self> {
        length("parameters", parameters.len(), PER_LINK * N)?;
        finite("parameters", parameters)?;
        let (of_links, _) = parameters.as_chunks::<PER_LINK>();
        let mut parameters = self.parameters;
        for (link, of_link) in parameters.links.iter_mut().zip(of_links) {
            link.inertia = Inertia::from_parameters(of_link);
        }
        self.rebuilt(parameters)
    }

    /// The same arm with stops at the ends of its joints' ranges, where [`limits`](Self::limits)
    /// are finite.
    ///
    /// # Errors
    /// As [`JointStop::validate`].
    pub fn with_stops(&self, stops: &[JointStop; N]) -> Result<Self> {
        let mut arm = *self;
        for (joint, stop) in stops.iter().enumerate() {
            stop.validate(joint)?;
            arm.parameters.links[joint].stop = *stop;
        }
        arm.has_stops = stops.iter().any(|stop| !stop.is_none());
        Ok(arm)
    }

    /// The same arm with a body fixed to its tip, given in the tip's frame.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `payload.…`: it must be a rigid body, whatever the arm's
    /// links are; as [`Serial::new_with`] if numbers overflow together.
    pub fn with_payload(&self, payload: &Inertia) -> Result<Self> {
        Unphysical::Refuse.take(payload, PAYLOAD, None)?;
        let mut parameters = self.parameters;
        let tip =
            Pose::new(joint::orthonormal(&parameters.tip.rotation), parameters.tip.translation);
        let last = &mut parameters.links[N - 1].inertia;
        *last = last.plus(&payload.transformed(&tip));
        self.rebuilt(parameters)
    }

    /// An arm of other parameters with the same policy for links that no rigid body can be.
    pub(super) fn rebuilt(&self, parameters: SerialParameters<N>) -> Result<Self> {
        Self::new_with(parameters, self.unphysical)
    }
}
