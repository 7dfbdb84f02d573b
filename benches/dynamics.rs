//! Dynamics of serial arms of 1 to 8 turning joints: inverse, mass matrix, forward, Jacobian. Every
//! call has another q.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../tests/common/chains.rs"]
#[allow(dead_code, unused_imports, unused_macros)]
mod chains;
#[path = "../tests/common/random.rs"]
mod random;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use random::Random;
use steadyarm::arm::{Arm, JointKind, Serial};
use steadyarm::math::Vector;

const SAMPLES: usize = 64;

fn arm<const N: usize>() -> Serial<N> {
    let mut parameters = *chains::chain::<N>(&mut Random(N as u64)).parameters();
    parameters.links.iter_mut().for_each(|link| link.kind = JointKind::Revolute);
    Serial::new(parameters).unwrap().without_friction()
}

fn bench_length<const N: usize>(criterion: &mut Criterion) {
    let (arm, mut random) = (arm::<N>(), Random(1));
    let samples: [[Vector<N>; 3]; SAMPLES] =
        [(); SAMPLES].map(|()| [(); 3].map(|()| chains::vector(&mut random, 1.0)));
    let mut bench = |name: &str, call: &dyn Fn(&[Vector<N>; 3])| {
        let mut k = 0;
        let mut group = criterion.benchmark_group(name);
        group.bench_function(BenchmarkId::from_parameter(N), |b| {
            b.iter(|| {
                k = (k + 1) % SAMPLES;
                call(&samples[k]);
            });
        });
    };
    bench("inverse_dynamics", &|[q, dq, u]| {
        black_box(arm.inverse_dynamics(q, dq, u));
    });
    bench("mass_matrix", &|[q, ..]| {
        black_box(arm.mass_matrix(q));
    });
    bench("forward_dynamics", &|[q, dq, u]| {
        black_box(arm.forward_dynamics(q, dq, u));
    });
    bench("mass_matrix_and_bias", &|[q, dq, _]| {
        black_box(arm.mass_matrix_and_bias(q, dq));
    });
    bench("jacobian", &|[q, ..]| {
        black_box(arm.jacobian(q));
    });
}

fn dynamics(criterion: &mut Criterion) {
    bench_length::<1>(criterion);
    bench_length::<2>(criterion);
    bench_length::<3>(criterion);
    bench_length::<4>(criterion);
    bench_length::<5>(criterion);
    bench_length::<6>(criterion);
    bench_length::<7>(criterion);
    bench_length::<8>(criterion);
}

criterion_group!(benches, dynamics);
criterion_main!(benches);
