//! Two rivals of one's own, on public traits alone: Slotine and Li's passive law as a `Law`, and a
//! disturbance observer as a `Dynamic`. Either goes with the other, or with what the crate brings.
//! The arm is twice as heavy as believed, and pushed.
#![allow(clippy::print_stdout, missing_docs)]

use std::ops::ControlFlow;

use steadyarm::arm::{Arm, JointFriction};
use steadyarm::control::{Applied, Compensator, ComputedTorque, Controller, Demand, Dynamic};
use steadyarm::control::{DynamicState, Law, NoCompensation, Sample, State};
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::sim::{Options, Status, simulate};

/// τ = M₀ a_r + C₀ v_r + G₀ + f₀ − K_D s − M₀ρ̂ with v_r = q̇_d − Λe, a_r = q̈_d − Λė, s = ė + Λe
/// (Slotine and Li 1987). Λ [1/s] and K_D [N·m·s] are the same for every joint.
#[derive(Clone, Copy)]
pub struct SlotineLi<A> {
    pub arm: A,
    pub lambda: f64,
    pub damping: f64,
}

impl<const N: usize, A: Arm<N>> Law<N> for SlotineLi<A> {
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N> {
        let Sample { q, dq, desired, e, de } = seen;
        let (v_r, a_r) = (desired.dq - e * self.lambda, desired.ddq - de * self.lambda);
        let (mass, s) = (self.arm.mass_matrix(q), de + e * self.lambda);
        let feedforward = mass * a_r + self.arm.coriolis(q, dq) * v_r + self.arm.gravity(q);
        let model = feedforward + self.arm.friction(dq) - s * self.damping;
        let v = self.arm.forward_dynamics(q, dq, &model);
        Demand { model, compensation: -(mass * rho_hat), v }
    }

    fn resting_torque(&self, q: &Vector<N>) -> Vector<N> {
        self.arm.gravity(q)
    }

    fn joint_friction(&self, joint: usize) -> JointFriction {
        self.arm.joint_friction(joint)
    }

    fn wraps(&self) -> [bool; N] {
        self.arm.wraps()
    }

    fn fingerprint(&self) -> u64 {
        self.arm.fingerprint()
    }
}

/// ρ̂ = z + l q̇, ż = −l (M₀⁻¹(τ − H₀) + ρ̂), so that ρ̂' = l (ρ − ρ̂) for the torque τ that acted:
/// the observer of Chen and others (2000) with the gain l M₀. It starts from ρ̂ = 0.
#[derive(Clone, Copy)]
pub struct Observer<A> {
    pub arm: A,
    /// l [1/s].
    pub pole: f64,
}

impl<const N: usize, A: Arm<N>> Dynamic<N, N> for Observer<A> {
    fn start(&self, seen: &Sample<N>) -> Vector<N> {
        -seen.dq * self.pole
    }

    fn estimate(&self, z: &Vector<N>, seen: &Sample<N>) -> Vector<N> {
        z + seen.dq * self.pole
    }

    fn rate(&self, z: &Vector<N>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<N> {
        let rho_hat: Vector<N> = z + seen.dq * self.pole;
        let believed = self.arm.forward_dynamics(&seen.q, &seen.dq, &applied.tau);
        (believed + rho_hat) * -self.pole
    }
}

/// RMS of e over the second half of 10 s [rad]; in continuous time, or sampled with a period [s].
pub fn rms<L, C, S>(
    law: L,
    compensator: C,
    memory: S,
    period: Option<f64>,
) -> steadyarm::Result<f64>
where
    L: Law<2>,
    C: Compensator<2, S>,
{
    let (plant, reference) = (paper::plant()?, paper::reference()?);
    let controller = Controller::new(law, compensator);
    let mut state = State::new(memory);
    let options = Options { duration: 10.0, control_period: period, ..Options::default() };
    let go_on = |_| ControlFlow::Continue(());
    let run = simulate(&plant, &controller, &mut state, &reference, &options, go_on)?;
    if run.status != Status::Finished {
        return Ok(f64::NAN);
    }
    let rows = &run.e[run.e.len() / 2..];
    let sum: f64 = rows.iter().flatten().map(|e| e * e).sum();
    Ok((sum / rows.len() as f64).sqrt())
}

fn main() -> steadyarm::Result<()> {
    let arm = paper::nominal()?;
    let passive = SlotineLi { arm, lambda: 3.0, damping: 5.0 };
    let computed = ComputedTorque::new(arm, paper::gains()?);
    let observer = Observer { arm, pole: 20.0 };
    println!("RMS of e, rad             alone     with the observer");
    for (time, period) in [("continuous", None), ("sampled, 1 ms", Some(1e-3))] {
        let alone = rms(passive, NoCompensation, (), period)?;
        let observed = rms(passive, observer, DynamicState::new(), period)?;
        println!("Slotine-Li, {time:13} {alone:.5}   {observed:.5}");
        let alone = rms(computed, NoCompensation, (), period)?;
        let observed = rms(computed, observer, DynamicState::new(), period)?;
        println!("computed,   {time:13} {alone:.5}   {observed:.5}");
    }
    Ok(())
}
