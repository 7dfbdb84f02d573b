//! No call of a serial arm's dynamics allocates, whatever it is given: under an allocator that
//! counts.

use std::hint::black_box;

use crate::chains;
use crate::counting::calls_during;
use crate::random::Random;
use steadyarm::arm::{Arm, Perturbation, Serial};
use steadyarm::math::Vector;

#[test]
fn the_allocator_counts() {
    assert!(calls_during(|| drop(black_box(vec![0.0; 100]))) == 2);
}

/// Any numbers: of an arm, of no arm, and no number at all.
fn vector<const N: usize>(random: &mut Random) -> Vector<N> {
    let mut v: Vector<N> = chains::vector(random, 5.0);
    if random.next() < -0.8 {
        v[0] = [f64::NAN, f64::INFINITY, 1e300][(random.between(0.0, 3.0)) as usize];
    }
    v
}

fn nothing_allocates<const N: usize>() {
    let mut random = Random(N as u64);
    let arm: Serial<N> = chains::chain(&mut random);
    let (mut y, mut pi) = (vec![0.0; 10 * N * N], vec![0.0; 10 * N]);
    let payload = chains::inertia(&mut random);
    let calls = calls_during(|| {
        for seed in 0..2000 {
            let [q, dq, u, v] = [(); 4].map(|()| vector::<N>(&mut random));
            black_box(arm.mass_matrix(&q));
            black_box(arm.coriolis(&q, &dq));
            black_box((arm.gravity(&q), arm.friction(&dq), arm.bias(&q, &dq)));
            black_box(arm.mass_matrix_and_bias(&q, &dq));
            black_box(arm.inverse_dynamics(&q, &dq, &u));
            black_box(arm.forward_dynamics(&q, &dq, &u));
            black_box((arm.kinetic_energy(&q, &dq), arm.potential_energy(&q)));
            black_box(arm.slotine_li(&q, &dq, &u, &v));
            black_box((arm.pose(&q), arm.link_poses(&q), arm.jacobian(&q)));
            arm.regressor(&q, &dq, &u, &mut y).unwrap();
            arm.inertial_parameters(&mut pi).unwrap();
            black_box(arm.regressor(&q, &dq, &u, &mut pi[..1]).unwrap_err());
            if seed < 20 {
                let _ = black_box((arm.without_friction(), arm.with_payload(&payload)));
                let by = Perturbation { mass: 0.2, com: 0.01, inertia: 0.2, friction: 0.5 };
                black_box(arm.perturb(seed, &by).unwrap());
            }
        }
    });
    assert_eq!(calls, 0);
}

#[test]
fn no_dynamics_call_allocates() {
    nothing_allocates::<1>();
    nothing_allocates::<2>();
    nothing_allocates::<6>();
    nothing_allocates::<7>();
    nothing_allocates::<8>();
}
