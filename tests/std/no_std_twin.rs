//! The controller of tests/no_std, with std: the same torques, to the bit. `tests/no_std/link.sh`
//! compares the lines printed.

#[path = "../common/no_std_scene.rs"]
mod scene;

/// Of all torques; regenerate with `cargo test --test std_tests no_std_twin -- --nocapture`.
const GOLDEN: u64 = 0x0999_57a6_65c3_eebf;

#[test]
fn torques_of_the_static_controller_are_the_same_with_std() {
    let mut tracker = scene::tracker([0.0; scene::MEMORY]).unwrap();
    let mut torques = Vec::new();
    let mut tau = [0.0; 2];
    for k in 0..1000 {
        let x = f64::from(k % 64) / 64.0;
        tau = scene::step(&mut tracker, [x - 0.5, 0.25 - x * x], [1.0 - x, x]).unwrap();
        torques.extend(tau);
    }
    let hash = crate::common::hash(torques);
    println!("torque {} {} hash {hash:016x}", tau[0], tau[1]);
    assert_eq!(hash, GOLDEN, "found {hash:#018x}");
}
