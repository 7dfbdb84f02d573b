//! Controllers in single precision behind C functions.

#[path = "../../common/no_std_single.rs"]
mod stepped;

use core::cell::UnsafeCell;

use self::stepped::Stepped;
use super::Static;

static ROOM: Static<[f64; 8192]> = Static(UnsafeCell::new([0.0; 8192]));
static TWO_LINK: Static<Option<Stepped<2>>> = Static(UnsafeCell::new(None));
static PANDA: Static<Option<Stepped<7>>> = Static(UnsafeCell::new(None));

/// Builds the controllers in single precision; call it once. 0 if that succeeded.
#[unsafe(no_mangle)]
pub extern "C" fn steadyarm_single_start() -> i32 {
    // SAFETY: called once, so that these are the only references.
    let (room, two_link, panda) =
        unsafe { (&mut *ROOM.0.get(), &mut *TWO_LINK.0.get(), &mut *PANDA.0.get()) };
    *two_link = stepped::two_link(room).ok();
    *panda = stepped::of_panda(room).ok();
    if two_link.is_some() && panda.is_some() { 0 } else { -1 }
}

/// One sample of the paper's controller in single precision, as `steadyarm_step`.
///
/// # Safety
/// `q` and `dq` point to two numbers each, `tau` to room for two.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn steadyarm_single_two_link(
    q: *const f32,
    dq: *const f32,
    tau: *mut f32,
) -> i32 {
    // SAFETY: see above, and no other reference to the controller is alive.
    unsafe { step(&mut *TWO_LINK.0.get(), q, dq, tau) }
}

/// One sample of that of a Panda: seven numbers each.
///
/// # Safety
/// As [`steadyarm_single_two_link`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn steadyarm_single_panda(
    q: *const f32,
    dq: *const f32,
    tau: *mut f32,
) -> i32 {
    // SAFETY: see above, and no other reference to the controller is alive.
    unsafe { step(&mut *PANDA.0.get(), q, dq, tau) }
}

/// # Safety
/// `q` and `dq` point to `N` numbers each, `tau` to room for as many.
unsafe fn step<const N: usize>(
    stepped: &mut Option<Stepped<N>>,
    q: *const f32,
    dq: *const f32,
    tau: *mut f32,
) -> i32 {
    // SAFETY: as the caller says.
    let (q, dq, tau) = unsafe { (*q.cast(), *dq.cast(), &mut *tau.cast::<[f32; N]>()) };
    match stepped.as_mut().and_then(|stepped| stepped.step(q, dq).ok()) {
        Some(torque) => {
            *tau = torque;
            0
        }
        None => -1,
    }
}
