//! Ten million steps of a guarded loop with faults; `benches/soak.rs` runs more.

use crate::soak::Soak;
use steadyarm::control::Event;

#[test]
fn ten_million_steps_with_faults_leave_finite_torques_within_their_limits() {
    let mut soak = Soak::new(1);
    soak.run(10_000_000);
    // Every kind of fault came, the guard stopped, and the loop tracked again after it.
    for event in [
        Event::NotFinite,
        Event::Jump,
        Event::Early,
        Event::Late,
        Event::Missed,
        Event::Clock,
        Event::EffortRate,
    ] {
        assert!(soak.count(event) > 100, "{soak}");
    }
    assert!(soak.stops > 100, "{soak}");
    assert!(soak.worst_calm_error < 0.15, "{soak}");
}
