//! The examples print what is written beside them: the same text in Rust and in Python.

use std::cell::RefCell;
use std::fmt::Debug;

thread_local! {
    static PRINTED: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Takes the place of the standard library's in the examples.
macro_rules! println {
    ($($text:tt)*) => {
        crate::examples::print(&format!($($text)*))
    };
}

fn print(line: &str) {
    PRINTED.with_borrow_mut(|printed| *printed += &format!("{line}\n"));
}

#[path = "../../examples/own_law.rs"]
mod compare;
#[path = "../../examples/02_compensate.rs"]
mod compensate;
#[path = "../../examples/05_payload.rs"]
mod payload;
#[path = "../../examples/06_save.rs"]
mod save;
#[path = "../../examples/03_step.rs"]
mod step;
#[path = "../../examples/01_track.rs"]
mod track;
#[path = "../../examples/04_urdf.rs"]
mod urdf;

fn prints<E: Debug>(main: fn() -> Result<(), E>, wanted: &str) {
    PRINTED.take();
    main().unwrap();
    assert_eq!(PRINTED.take(), wanted);
}

#[test]
fn an_arm_follows_its_path() {
    prints(track::main, include_str!("../../examples/01_track.txt"));
}

#[test]
fn a_compensator_learns() {
    prints(compensate::main, include_str!("../../examples/02_compensate.txt"));
}

#[test]
fn a_loop_of_ones_own_steps() {
    prints(step::main, include_str!("../../examples/03_step.txt"));
}

#[test]
fn an_arm_comes_from_a_urdf() {
    prints(urdf::main, include_str!("../../examples/04_urdf.txt"));
}

#[test]
fn a_panda_carries_a_payload() {
    prints(payload::main, include_str!("../../examples/05_payload.txt"));
}

#[test]
fn a_law_of_ones_own_stands_in_the_table() {
    prints(compare::main, include_str!("../../examples/own_law.txt"));
}

#[test]
fn what_was_learnt_is_saved() {
    prints(save::main, include_str!("../../examples/06_save.txt"));
}
