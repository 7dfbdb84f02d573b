//! What a law, or a compensator, that only `laws` knows believes.

use core::any::Any;

use crate::arm::Side;

/// Two arms that a law or a compensator believes in, and numbers, of which only those know more who
/// gave them.
#[derive(Clone, Copy, Debug)]
pub struct Beliefs<'a, const N: usize> {
    pub(crate) arms: [Side<'a, N>; 2],
    pub(crate) numbers: &'a dyn Any,
}
