//! 04: your own robot from a URDF, and its dynamics: M(q) q̈ + H(q, q̇) = τ.
#![allow(clippy::print_stdout, missing_docs)]

use std::error::Error;

use steadyarm::arm::{Arm, Serial};
use steadyarm::robot::{Description, GRAVITY};

const URDF: &str = include_str!("04_arm.urdf");

pub fn main() -> Result<(), Box<dyn Error>> {
    let robot = Description::from_urdf(URDF, Some("base"), Some("tool"), GRAVITY)?;
    let arm: Serial<3> = robot.arm()?;
    let names: Vec<_> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
    println!("joints: {}", names.join(", "));

    // m and rad, m/s and rad/s, …
    let q = [0.3, 0.5, -0.8].into();
    let (dq, ddq) = ([0.1, 0.2, -0.4].into(), [0.5, 1.0, 2.0].into());

    let mass = arm.mass_matrix(&q);
    for (name, n) in [("M [kg·m²]", 0), ("", 1), ("", 2)] {
        row(name, [mass[(n, 0)], mass[(n, 1)], mass[(n, 2)]]);
    }
    row("H [N·m]", arm.bias(&q, &dq).into()); // C q̇ + G + friction
    let tau = arm.inverse_dynamics(&q, &dq, &ddq);
    row("tau [N·m]", tau.into());
    row("ddq", arm.forward_dynamics(&q, &dq, &tau).into());
    row("tip [m]", arm.pose(&q).translation.into());
    Ok(())
}

/// Prints a line of numbers.
fn row(name: &str, [x, y, z]: [f64; 3]) {
    println!("{name:10} {x:+10.5} {y:+10.5} {z:+10.5}");
}
