//! What a law believes of an arm, in single precision.

use super::JointFriction;
use super::planar::{Planar, two};
use super::serial::{Chain, Frame, Links};
use super::side::{Form, Side};
use crate::math::{Matrix, Real, Vector};

/// An arm without stops and dry friction.
#[derive(Clone, Debug)]
pub(crate) struct SingleArm<const N: usize> {
    body: Body<N>,
    friction: Option<[JointFriction<f32>; N]>,
}

#[derive(Clone, Debug)]
enum Body<const N: usize> {
    /// Only where `N` is 2.
    TwoLink(Planar<f32>),
    Chain(Chain<N, f32>),
}

impl<const N: usize> SingleArm<N> {
    /// This one.
    pub fn of(Side { form, friction }: Side<'_, N>) -> Self {
        let body = match form {
            Form::TwoLink(arm) => Body::TwoLink(arm.single()),
            Form::Chain(chain) => Body::Chain(chain.single()),
        };
        Self { body, friction: friction.map(|joints| joints.map(|joint| joint.single())) }
    }

    /// M and H = C q̇ + G + f.
    pub fn mass_matrix_and_bias(
        &self,
        q: &Vector<N, f32>,
        dq: &Vector<N, f32>,
    ) -> (Matrix<N, f32>, Vector<N, f32>) {
        let (mass, mut bias) = match &self.body {
            Body::TwoLink(arm) => {
                let (q, dq) = (two(q), two(dq));
                arm.dynamics(arm.first(q[0]), Real::sin_cos(q[1]), &dq)
            }
            Body::Chain(chain) => {
                let (mut frames, mut mass) = ([Frame::place(0.0); N], Matrix::<N, f32>::zeros());
                chain.find(q, dq, &mut frames);
                chain.write_mass_matrix(&mut frames, &mut mass);
                (mass, chain.bias(&frames))
            }
        };
        if let Some(friction) = &self.friction {
            for n in 0..N {
                bias[n] += friction[n].torque(dq[n]);
            }
        }
        (mass, bias)
    }
}

impl Planar {
    fn single(&self) -> Planar<f32> {
        let Self { theta, det_0, weight, has_gravity } = *self;
        let (theta, weight) = (theta.map(|x| x as f32), weight.map(|x| x as f32));
        Planar { theta, det_0: det_0 as f32, weight, has_gravity }
    }
}

impl JointFriction {
    fn single(&self) -> JointFriction<f32> {
        let Self { viscous, coulomb, stribeck, stribeck_speed, smoothing } = *self;
        JointFriction {
            viscous: viscous as f32,
            coulomb: coulomb.map(|x| x as f32),
            stribeck: stribeck as f32,
            stribeck_speed: stribeck_speed as f32,
            smoothing: smoothing as f32,
        }
    }
}
