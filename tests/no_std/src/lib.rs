//! A controller in static memory behind a C function, without std and without an allocator.
#![no_std]

#[cfg(feature = "single")]
#[path = "../../common/panda_numbers.rs"]
mod panda_numbers;
#[path = "../../common/no_std_scene.rs"]
mod scene;
#[cfg(feature = "single")]
mod single;

use core::cell::UnsafeCell;
use core::panic::PanicInfo;

use scene::{MEMORY, Tracker};

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}

struct Static<T>(UnsafeCell<T>);

// SAFETY: the C program has one thread.
unsafe impl<T> Sync for Static<T> {}

static BUFFER: Static<[f64; MEMORY]> = Static(UnsafeCell::new([0.0; MEMORY]));
static TRACKER: Static<Option<Tracker<&'static mut [f64]>>> = Static(UnsafeCell::new(None));

/// Builds the controller; call it once. 0 if that succeeded.
#[unsafe(no_mangle)]
pub extern "C" fn steadyarm_start() -> i32 {
    // SAFETY: called once, so that this is the only reference to the buffer.
    let (buffer, tracker) = unsafe { (&mut *BUFFER.0.get(), &mut *TRACKER.0.get()) };
    *tracker = scene::tracker(&mut buffer[..]).ok();
    if tracker.is_some() { 0 } else { -1 }
}

/// One sample: position and velocity in, torque out, each of two joints. 0 if the sample was
/// accepted.
///
/// # Safety
/// `q` and `dq` point to two numbers each, `tau` to room for two.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn steadyarm_step(q: *const f64, dq: *const f64, tau: *mut f64) -> i32 {
    // SAFETY: see above, and no other reference to the tracker is alive.
    let (tracker, q, dq, tau) = unsafe {
        (&mut *TRACKER.0.get(), &*q.cast::<[f64; 2]>(), &*dq.cast(), &mut *tau.cast::<[f64; 2]>())
    };
    match tracker.as_mut().and_then(|tracker| scene::step(tracker, *q, *dq).ok()) {
        Some(torque) => {
            *tau = torque;
            0
        }
        None => -1,
    }
}

/// Bytes of controller, basis, state, and of the memory lent to the state.
///
/// # Safety
/// `sizes` points to room for four numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn steadyarm_sizes(sizes: *mut usize) {
    // SAFETY: see above, and no other reference to the tracker is alive.
    let (tracker, sizes) = unsafe { (&*TRACKER.0.get(), &mut *sizes.cast::<[usize; 4]>()) };
    *sizes = tracker.as_ref().map_or([0; 4], scene::sizes);
}
