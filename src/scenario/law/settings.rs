//! Parameters of each law.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::laws::Mismatch;
use crate::scenario::{BasisSettings, CompensatorSettings, PerJoint};

/// A law with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case")]
pub enum LawSettings {
    /// Computed torque, with a compensator or without.
    ComputedTorque(ComputedTorqueSettings),
    /// PD with gravity.
    PdGravity(PdGravitySettings),
    /// Computed torque with the integral of the error.
    Pid(PidSettings),
    /// Computed torque with variable structure.
    SlidingMode(SlidingModeSettings),
    /// Robust computed torque.
    Robust(RobustSettings),
    /// Nonlinear H∞.
    HInfinity(HInfinitySettings),
    /// Super-twisting.
    SuperTwisting(SuperTwistingSettings),
    /// The integral of the sign of the error.
    Rise(RiseSettings),
    /// Slotine and Li's passive law, its parameters adapted.
    SlotineLi(SlotineLiSettings),
    /// The same with the natural adaptation.
    NaturalSlotineLi(SlotineLiSettings),
    /// The passivity form of the fuzzy law.
    PassiveFuzzy(PassiveFuzzySettings),
    /// Computed torque with a network of radial basis functions.
    RbfNetwork(RbfNetworkSettings),
    /// Computed torque whose model adapts.
    AdaptiveComputedTorque(AdaptiveComputedTorqueSettings),
    /// Time-delay control.
    TimeDelay(TimeDelaySettings),
    /// Computed torque with a disturbance observer.
    DisturbanceObserver(DisturbanceObserverSettings),
    /// Computed torque with a momentum observer.
    MomentumObserver(MomentumObserverSettings),
    /// The one that we recommend: all gains from a rule.
    Recommended(RecommendedSettings),
}

/// Settings of a law: a bandwidth, or its gains; and what goes with either.
macro_rules! settings {
    ($(
        $(#[$meta:meta])*
        $name:ident {
            $($(#[$gain_meta:meta])* $gain:ident),*
        } also {
            $($(#[$also_meta:meta])* $also:ident: $type:ty),*
        }
    )*) => {$(
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            /// [rad/s], in place of all gains.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub bandwidth: Option<PerJoint>,
            $(
                $(#[$gain_meta])*
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $gain: Option<PerJoint>,
            )*
            $(
                $(#[$also_meta])*
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $also: Option<$type>,
            )*
        }

        impl $name {
            /// The bandwidth of `N` joints, if it stands in the place of gains.
            pub(super) fn by_bandwidth<const N: usize>(&self) -> Result<Option<[f64; N]>> {
                let Some(bandwidth) = &self.bandwidth else { return Ok(None) };
                $(if let Some(given) = &self.$gain {
                    let wanted = "no value beside a bandwidth: one or the other";
                    let first = given.as_slice().first().copied().unwrap_or_default();
                    return Err(Error::out_of_range(stringify!($gain), first, wanted));
                })*
                bandwidth.each("bandwidth").map(Some)
            }
        }
    )*};
}

settings! {
    /// Computed torque.
    ComputedTorqueSettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv
    } also {
        /// What is learnt beside the model.
        compensator: CompensatorSettings
    }

    /// PD with gravity.
    PdGravitySettings {
        /// [N·m/rad].
        stiffness,
        /// [N·m·s/rad].
        damping
    } also {}

    /// Computed torque with an integral.
    PidSettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv,
        /// K_i [1/s³].
        ki
    } also {
        /// What the model may miss.
        uncertainty: MismatchSettings
    }

    /// Computed torque with variable structure.
    SlidingModeSettings {
        /// Λ [1/s].
        slope,
        /// K [rad/s²].
        gain,
        /// φ [rad/s].
        layer,
        /// k₀ [1/s].
        linear
    } also {
        /// What the model may miss; needed for a bandwidth.
        uncertainty: MismatchSettings
    }

    /// Robust computed torque.
    RobustSettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv,
        /// On the diagonal of Q.
        q,
        /// ρ [rad/s²].
        bound,
        /// ε.
        layer
    } also {
        /// γ of (19), whose P is taken in place of Lyapunov's.
        gamma: f64,
        /// What the model may miss; needed for a bandwidth.
        uncertainty: MismatchSettings
    }

    /// Nonlinear H∞.
    HInfinitySettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv,
        /// On the diagonal of Q.
        q,
        /// γ.
        gamma,
        /// r.
        r
    } also {}

    /// Super-twisting.
    SuperTwistingSettings {
        /// Λ [1/s].
        slope,
        /// k₁ [√rad/s^1.5].
        k1,
        /// k₂ [rad/s³].
        k2
    } also {
        /// What the model may miss; needed for a bandwidth.
        uncertainty: MismatchSettings
    }

    /// The integral of the sign of the error.
    RiseSettings {
        /// α₁ [1/s].
        alpha1,
        /// α₂ [1/s].
        alpha2,
        /// k_s [1/s].
        ks,
        /// β [rad/s³].
        beta
    } also {
        /// What the model may miss; needed for a bandwidth.
        uncertainty: MismatchSettings
    }

    /// Slotine and Li's law.
    SlotineLiSettings {
        /// Λ [1/s].
        slope,
        /// K_D [N·m·s/rad].
        damping,
        /// Γ, of all parameters; [1/J] for the natural one.
        gain
    } also {
        /// What the arm will move like, for a bandwidth: speed [rad/s].
        speed: PerJoint,
        /// And acceleration [rad/s²].
        acceleration: PerJoint
    }

    /// The passivity form of the fuzzy law; the gain of learning is the compensator's.
    PassiveFuzzySettings {
        /// Λ [1/s].
        slope,
        /// K_D [N·m·s/rad].
        damping
    } also {
        /// Basis, inputs and modifications.
        compensator: CompensatorSettings
    }

    /// A network of radial basis functions over (e, ė).
    RbfNetworkSettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv,
        /// On the diagonal of Q.
        q,
        /// g.
        gain
    } also {
        /// Centres, of every input.
        centers: Vec<f64>,
        /// b.
        width: f64
    }

    /// Computed torque whose model adapts.
    AdaptiveComputedTorqueSettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv,
        /// On the diagonal of Q.
        q,
        /// g.
        gain,
        /// Of the filter of q̈ \[Hz\].
        cutoff
    } also {
        /// What the arm will move like, for a bandwidth: speed [rad/s].
        speed: PerJoint,
        /// And acceleration [rad/s²].
        acceleration: PerJoint
    }

    /// Time-delay control.
    TimeDelaySettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv,
        /// M̄ as a share of M₀.
        share
    } also {
        /// What the model may miss.
        uncertainty: MismatchSettings
    }

    /// Computed torque with a disturbance observer.
    DisturbanceObserverSettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv,
        /// Y [N·m·s/rad].
        gain
    } also {}

    /// Computed torque with a momentum observer.
    MomentumObserverSettings {
        /// K_p [1/s²].
        kp,
        /// K_v [1/s].
        kv,
        /// l [1/s].
        pole
    } also {}
}

/// The recommended controller: what its rule is told.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecommendedSettings {
    /// Bits of the encoders; absent: 16.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoder_bits: Option<PerJoint>,
    /// Standard deviation of a measured position beside its rounding \[rad\]; absent: 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<PerJoint>,
    /// The heaviest load at the tip \[kg\]; absent: a sixth of the arm's mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<f64>,
    /// Bounds of the arm's inertia as multiples of what is believed; absent: 1 and 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia_range: Option<[f64; 2]>,
    /// Largest torques \[N·m\], where the controller has no limits and the arm says none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<PerJoint>,
    /// Whether only a load at the tip, and friction, are learnt, and no other link.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub payload_only: bool,
    /// Whether a joint that looks too light for its torque is meant so, and has no rotor.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub light_joints: bool,
    /// A basis for what no parameter describes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual: Option<BasisSettings>,
}

/// What the model may miss, as [`Mismatch`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MismatchSettings {
    /// A bound a of ‖I − M⁻¹M₀‖, below 1.
    pub inertia: f64,
    /// A bound v̄ of the acceleration that the law asks for \[rad/s²\].
    pub acceleration: f64,
    /// A bound d̄ of all else, as an acceleration \[rad/s²\].
    pub disturbance: f64,
}

impl From<&MismatchSettings> for Mismatch {
    fn from(settings: &MismatchSettings) -> Self {
        let MismatchSettings { inertia, acceleration, disturbance } = *settings;
        Self { inertia, acceleration, disturbance }
    }
}
