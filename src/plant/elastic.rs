//! Joints that give: between each motor and its link a gear with stiffness K, damping D and play
//! (the model of Spong, with backlash),
//!
//! ```text
//! M(q) q̈ + H + s + τ_d = τ_J    B θ̈ + τ_J = τ    τ_J = K φ + D φ̇,  φ = φ(θ − q)
//! ```
//!
//! θ is the motor's angle on the link's side of the gear, B its inertia there, τ what the drive
//! applies, and φ a dead zone of half the backlash to each side. Where there is play the gear only
//! pushes, τ_J φ ≥ 0.
//!
//! A step is made of parts of at most 0.2/ω, where `ω² = Σ Kᵢ wᵢ` or `ω = Σ Dᵢ wᵢ`, with
//! `w = 1/B + (M⁻¹)ᵢᵢ`, bounds the fastest mode; its frequency is then right to 0.3 %. In each part
//! τ_J is the mean by which the gear's energy is exact, with ends ₀ and ₁ and x = θ − q,
//!
//! ```text
//! τ_J = ½ K (φ₁² − φ₀²)/(x₁ − x₀) + D (φ₁ − φ₀)/h
//! ```
//!
//! so that a gear takes energy out and never puts any in, whatever the step.
//!
//! Sources: M. W. Spong, "Modeling and control of elastic joint robots", ASME J. Dyn. Sys. 109
//! (1987); M. Nordin, P.-O. Gutman, "Controlling mechanical systems with backlash", Automatica 38
//! (2002); O. Gonzalez, "Time integration and discrete Hamiltonian systems", J. Nonlinear Sci. 6
//! (1996).

use crate::arm::{Arm, Posed};
use crate::error::{Result, non_negative, positive};
use crate::math::{Vector, sqrt};

/// ω times the length of a part.
const MOST_TURN: f64 = 0.2;
/// Parts of a step at the most.
const MOST_PARTS: f64 = 1e5;
/// How often τ_J is improved at the most, and when it is good: relative to the largest.
const MOST_TRIES: usize = 16;
const SAME: f64 = 1e-12;

/// Gears between the motors and the links of an arm, whose own rotors are then to be left out: they
/// are here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic<const N: usize> {
    stiffness: Vector<N>,
    damping: Vector<N>,
    rotor_inertia: Vector<N>,
    backlash: Vector<N>,
}

/// q \[rad\] and q̇ [rad/s] of the links.
type Links<const N: usize> = (Vector<N>, Vector<N>);

/// The motors' side of the gears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorState<const N: usize> {
    /// θ \[rad\], on the links' side of the gears.
    pub theta: Vector<N>,
    /// θ̇ [rad/s].
    pub dtheta: Vector<N>,
}

impl<const N: usize> Elastic<N> {
    /// Gears of this stiffness K [N·m/rad] and motors of this inertia B [kg·m²], seen from the
    /// links, without damping and play. N/m and kg for a prismatic joint.
    ///
    /// # Errors
    /// `stiffness`, `rotor_inertia`: not finite or not > 0.
    pub fn new(stiffness: [f64; N], rotor_inertia: [f64; N]) -> Result<Self> {
        positive("stiffness", &stiffness)?;
        positive("rotor_inertia", &rotor_inertia)?;
        let (stiffness, rotor_inertia) = (stiffness.into(), rotor_inertia.into());
        Ok(Self { stiffness, rotor_inertia, damping: Vector::zeros(), backlash: Vector::zeros() })
    }

    /// The same with this damping D [N·m·s/rad].
    ///
    /// # Errors
    /// `damping`: not finite or not ≥ 0.
    pub fn with_damping(self, damping: [f64; N]) -> Result<Self> {
        non_negative("damping", &damping)?;
        Ok(Self { damping: damping.into(), ..self })
    }

    /// The same with this play from end to end \[rad\].
    ///
    /// # Errors
    /// `backlash`: not finite or not ≥ 0.
    pub fn with_backlash(self, backlash: [f64; N]) -> Result<Self> {
        non_negative("backlash", &backlash)?;
        Ok(Self { backlash: backlash.into(), ..self })
    }

    /// Motors that turn with the links at `q`, `dq` and give them this torque [N·m] through the
    /// gears; in the middle of the play for none.
    pub fn carrying(&self, q: &Vector<N>, dq: &Vector<N>, torque: &Vector<N>) -> MotorState<N> {
        let twist = |i: usize| {
            let side = if torque[i] == 0.0 { 0.0 } else { torque[i].signum() };
            torque[i] / self.stiffness[i] + 0.5 * side * self.backlash[i]
        };
        MotorState { theta: Vector::from_fn(|i, _| q[i] + twist(i)), dtheta: *dq }
    }

    /// What the gears give to the links, τ_J [N·m].
    pub fn gear_torque(&self, q: &Vector<N>, dq: &Vector<N>, motor: &MotorState<N>) -> Vector<N> {
        Vector::from_fn(|i, _| {
            let phi = self.phi(i, motor.theta[i] - q[i]);
            let apart = phi != 0.0 || self.backlash[i] == 0.0;
            let rate = if apart { motor.dtheta[i] - dq[i] } else { 0.0 };
            self.stiffness[i] * phi + self.damping[i] * rate
        })
    }

    /// Energy of gears and motors, Σ ½ K φ² + ½ B θ̇² \[J\].
    pub fn energy(&self, q: &Vector<N>, motor: &MotorState<N>) -> f64 {
        (0..N).fold(0.0, |sum, i| {
            let (phi, speed) = (self.phi(i, motor.theta[i] - q[i]), motor.dtheta[i]);
            sum + 0.5 * (self.stiffness[i] * phi * phi + self.rotor_inertia[i] * speed * speed)
        })
    }

    /// Moves links and motors from time `t` \[s\] on by `h` under the torque `tau` [N·m] that the
    /// drives hold, and returns the links' q and q̇ then.
    ///
    /// `link` moves the links alone: it is given (q, q̇), the torque of the gears, which no limit
    /// of the drives may cut, a time and a length, and must give the same for the same. It is asked
    /// some times in every part, and stands for disturbance, friction and stops; `sim::hold_torque`
    /// of a plant without effort limit is one.
    pub fn advance<A: Arm<N>>(
        &self,
        arm: &A,
        (q, dq): Links<N>,
        motor: &mut MotorState<N>,
        tau: &Vector<N>,
        (t, h): (f64, f64),
        mut link: impl FnMut(&Links<N>, &Vector<N>, f64, f64) -> Links<N>,
    ) -> Links<N> {
        let compliance = self.compliance(arm, &q, &dq);
        let parts = self.parts(&compliance, h);
        let part = h / parts;
        let (mut links, mut k) = ((q, dq), 0.0);
        while k < parts {
            let gears = Part { gears: self, compliance: &compliance, h: part, tau };
            links = gears.step(&links, motor, |at, torque| link(at, torque, t + k * part, part));
            k += 1.0;
        }
        links
    }

    /// w = 1/B + (M⁻¹)ᵢᵢ.
    fn compliance<A: Arm<N>>(&self, arm: &A, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        self.rotor_inertia.map(|b| 1.0 / b) + Posed::of(arm, q, dq).factor.inverse_diagonal()
    }

    /// Into how many parts a step of `h` \[s\] is cut.
    fn parts(&self, compliance: &Vector<N>, h: f64) -> f64 {
        let fast = sqrt(self.stiffness.dot(compliance)).max(self.damping.dot(compliance));
        libm::ceil(h * fast / MOST_TURN).clamp(1.0, MOST_PARTS)
    }

    /// φ of joint `i` at the twist x = θ − q.
    fn phi(&self, i: usize, twist: f64) -> f64 {
        let half = 0.5 * self.backlash[i];
        twist - twist.clamp(-half, half)
    }
}

/// One part of a step.
struct Part<'a, const N: usize> {
    gears: &'a Elastic<N>,
    compliance: &'a Vector<N>,
    h: f64,
    tau: &'a Vector<N>,
}

impl<const N: usize> Part<'_, N> {
    /// Links and motors at its end; `link` gives the links there for a torque of the gears.
    fn step(
        &self,
        links: &Links<N>,
        motor: &mut MotorState<N>,
        mut link: impl FnMut(&Links<N>, &Vector<N>) -> Links<N>,
    ) -> Links<N> {
        let before = motor.theta - links.0;
        let first = before + (motor.dtheta - links.1) * self.h;
        let mut torque = Vector::from_fn(|i, _| self.torque(i, before[i], first[i]));
        let (mut moved, mut turned) = (link(links, &torque), self.turned(motor, &torque));
        for _ in 1..MOST_TRIES {
            let after = turned.theta - moved.0;
            let given = Vector::from_fn(|i, _| self.torque(i, before[i], after[i]));
            let off: Vector<N> = given - torque;
            if off.amax() <= SAME * given.amax() {
                break;
            }
            torque += Vector::from_fn(|i, _| off[i] / (1.0 + self.slope(i, after[i])));
            (moved, turned) = (link(links, &torque), self.turned(motor, &torque));
        }
        *motor = turned;
        moved
    }

    /// The motors at the end under this torque of the gears: B θ̈ = τ − τ_J.
    fn turned(&self, motor: &MotorState<N>, torque: &Vector<N>) -> MotorState<N> {
        let ddtheta = (self.tau - torque).component_div(&self.gears.rotor_inertia);
        let dtheta = motor.dtheta + ddtheta * self.h;
        MotorState { theta: motor.theta + (motor.dtheta + dtheta) * (0.5 * self.h), dtheta }
    }

    /// Mean torque of gear `i` on the way from one twist to another.
    fn torque(&self, i: usize, before: f64, after: f64) -> f64 {
        let gears = self.gears;
        let (phi_0, phi_1) = (gears.phi(i, before), gears.phi(i, after));
        let way = after - before;
        // (φ₁ − φ₀)/(x₁ − x₀): the share of the way that is in contact.
        let in_contact = if way == 0.0 { 1.0 } else { (phi_1 - phi_0) / way };
        let elastic = gears.stiffness[i] * (0.5 * (phi_0 + phi_1) * in_contact);
        let torque = elastic + gears.damping[i] * (phi_1 - phi_0) / self.h;
        if gears.backlash[i] > 0.0 && torque * (phi_0 + phi_1) <= 0.0 { 0.0 } else { torque }
    }

    /// How fast that falls with the torque itself, which moves the end: by h² w/2.
    fn slope(&self, i: usize, after: f64) -> f64 {
        let gears = self.gears;
        let contact = gears.backlash[i] == 0.0 || gears.phi(i, after) != 0.0;
        let stiffness = 0.5 * gears.stiffness[i] + gears.damping[i] / self.h;
        if contact { 0.5 * self.h * self.h * self.compliance[i] * stiffness } else { 0.0 }
    }
}
