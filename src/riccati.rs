//! stub
#![allow(missing_docs)]
use crate::error::*;
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointSolution {
    pub p11: f64,
    pub p12: f64,
    pub p22: f64,
}
pub fn joint(kp: f64, kv: f64, q1: f64, q2: f64, gamma: f64) -> Result<JointSolution> {
    let g = 1.0 / (gamma * gamma);
    let s = crate::math::sqrt;
    let p12 = q1 / (kp + s(kp * kp - g * q1));
    let p22 = (q2 + 2.0 * p12) / (kv + s(kv * kv - g * (q2 + 2.0 * p12)));
    Ok(JointSolution { p12, p22, p11: kv * p12 + kp * p22 - g * p12 * p22 })
}
