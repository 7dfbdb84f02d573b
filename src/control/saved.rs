//! A controller's memory as bytes: versioned, checksummed, and exact to the bit.
//!
//! Layout, little-endian: `steadyarm` magic and version · joints, rules, flags · steps, advances ·
//! last torque · fingerprints of arm, gains, compensator, basis · the pending period, if there is
//! one: dt, torque asked for and commanded, q, q̇, q_d, q̇_d, q̈_d · memory of the front, if it has
//! one: last period, age, vectors · the compensator's part · FNV-1a checksum of all that. Version 1
//! has neither fingerprints nor a pending period.
//!
//! Nothing is allocated: bytes are written as they come, and read in two passes. The first pass
//! checks all there is, the second one cannot fail.

use super::bytes::{Numbers, put_all};
use super::checks::{check_period, check_sample};
use super::front::FrontMemory;
use super::state::{IMPOSSIBLE, Pending};
use super::{Applied, Compensator, Controller, Law, NoCompensation, Sample, Stage, State};
use crate::error::{Error, Result, length};
use crate::math::{FNV_START, Vector, fnv};
use crate::reference::Setpoint;

const MAGIC: &[u8; 11] = b"steadyarm\0\0";
const VERSION: u8 = 2;

/// Flags of every controller; those of a compensator are its own.
const TORQUE: u64 = 4;
const PENDING: u64 = 32;
const FRONT: u64 = 64;

/// Counters are below this, so that none can wrap.
pub(super) const MAX_COUNT: u64 = 1 << 62;

/// Who wrote a saved state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A controller with the same arm, gains, compensator and basis.
    Same,
    /// One that differs in some of them.
    Other,
    /// Not known: the file is of version 1, which does not say.
    Unknown,
}

/// A compensator whose state can be saved and restored, to the bit.
pub trait Saves<const N: usize, S>: Compensator<N, S> {
    /// All flags that [`flags`](Self::flags) may set; 4, 32 and 64 are taken.
    fn known_flags(&self) -> u64;

    /// What the entries are called that [`size`](Self::size) counts.
    fn entries(&self) -> &'static str;

    /// The size of its memory.
    fn size(&self) -> usize;

    /// Fingerprints of what gives the memory its meaning: of the update law, and of the basis.
    fn fingerprints(&self) -> [u64; 2];

    /// What there is in its part.
    fn flags(&self, state: &S) -> u64;

    /// Whether it has a counter of its own; the word of one that has none is 0.
    fn has_counter(&self) -> bool {
        false
    }

    /// Its counter.
    fn advances(&self, _: &S) -> u64 {
        0
    }

    /// Writes its part, in numbers of eight bytes.
    fn write(&self, state: &S, put: &mut dyn FnMut(&[u8]));

    /// Checks a part that claims to have these flags, whole.
    ///
    /// # Errors
    /// [`Damaged`](crate::Problem::Damaged), and what names a size or a value.
    fn check(&self, flags: u64, part: &[u8]) -> Result<()>;

    /// Takes a part that was checked.
    fn take(&self, state: &mut S, flags: u64, advances: u64, part: &[u8]);
}

impl<const N: usize> Saves<N, ()> for NoCompensation {
    fn known_flags(&self) -> u64 {
        0
    }

    fn entries(&self) -> &'static str {
        "rules"
    }

    fn size(&self) -> usize {
        0
    }

    fn fingerprints(&self) -> [u64; 2] {
        [0; 2]
    }

    fn flags(&self, (): &()) -> u64 {
        0
    }

    fn write(&self, (): &(), _: &mut dyn FnMut(&[u8])) {}

    fn check(&self, _: u64, part: &[u8]) -> Result<()> {
        Numbers(part).end()
    }

    fn take(&self, (): &mut (), _: u64, _: u64, _: &[u8]) {}
}

impl<const N: usize, L: Law<N>, C> Controller<N, L, C> {
    /// The state as bytes; what is pending is a part of it.
    #[cfg(feature = "std")]
    pub fn save<S>(&self, state: &State<N, S>) -> Vec<u8>
    where
        C: Saves<N, S>,
    {
        let mut bytes = Vec::new();
        self.save_to(state, &mut |more| bytes.extend_from_slice(more));
        bytes
    }

    /// The same, handed to `put` piece by piece.
    pub fn save_to<S>(&self, state: &State<N, S>, put: &mut dyn FnMut(&[u8]))
    where
        C: Saves<N, S>,
    {
        let mut sum = FNV_START;
        let mut all = |bytes: &[u8]| {
            sum = fnv(sum, bytes);
            put(bytes);
        };
        let State { compensator: own, last_tau, steps, pending, front } = state;
        let compensator = &self.compensator;
        let mut flags = compensator.flags(own);
        flags |= if last_tau.is_some() { TORQUE } else { 0 };
        flags |= if pending.is_some() { PENDING } else { 0 };
        flags |= if self.front.is_on() { FRONT } else { 0 };
        all(MAGIC);
        all(&[VERSION]);
        let counts = [N as u64, compensator.size() as u64, flags, *steps];
        counts.iter().for_each(|count| all(&count.to_le_bytes()));
        all(&compensator.advances(own).to_le_bytes());
        put_all(&mut all, last_tau.unwrap_or_else(Vector::zeros).as_slice());
        self.fingerprints().iter().for_each(|print| all(&print.to_le_bytes()));
        if let Some(Pending { sample, applied, dt }) = pending {
            let Sample { q, dq, desired, .. } = sample;
            put_all(&mut all, &[*dt]);
            let Applied { asked, tau, .. } = applied;
            for vector in [asked, tau, q, dq, &desired.q, &desired.dq, &desired.ddq] {
                put_all(&mut all, vector.as_slice());
            }
        }
        if self.front.is_on() {
            front.write(&mut all);
        }
        compensator.write(own, &mut all);
        put(&sum.to_le_bytes());
    }

    /// Restores what `save` wrote, bit for bit: [`Origin::Same`], or
    /// [`Origin::Unknown`] for a file of version 1.
    ///
    /// # Errors
    /// [`Damaged`](crate::Problem::Damaged) for bytes that were cut, changed, or are not possible;
    /// `joints`, `rules`, `sets`, `capacity`: the state of a controller of another size;
    /// [`OtherController`](crate::Problem::OtherController) of one that differs in its nominal arm,
    /// gains, compensator or basis; `weights`: farther off than the projection's radius. The state
    /// is then as before.
    pub fn restore<S>(&self, state: &mut State<N, S>, bytes: &[u8]) -> Result<Origin>
    where
        C: Saves<N, S>,
    {
        self.open(bytes, false).map(|saved| self.take(state, &saved))
    }

    /// The same for the state of a controller of the same size with another arm, other gains or
    /// sets: whether its weights are right here is for the caller to know. The period that was
    /// pending there is left out, as this controller would learn something else from it.
    ///
    /// # Errors
    /// As [`restore`](Self::restore), but for `OtherController`.
    pub fn restore_from_other<S>(&self, state: &mut State<N, S>, bytes: &[u8]) -> Result<Origin>
    where
        C: Saves<N, S>,
    {
        self.open(bytes, true).map(|saved| self.take(state, &saved))
    }

    /// What gives a state its meaning: arm, gains, compensator, basis.
    fn fingerprints<S>(&self) -> [u64; 4]
    where
        C: Saves<N, S>,
    {
        let [compensator, basis] = self.compensator.fingerprints();
        let tuning = self.front.fingerprint(self.law.tuning());
        [self.law.fingerprint(), tuning, compensator, basis]
    }

    /// All that the bytes say, checked; with `other` also those of another controller.
    fn open<'a, S>(&self, bytes: &'a [u8], other: bool) -> Result<Opened<'a, N>>
    where
        C: Saves<N, S>,
    {
        let (version, mut rest) = unsealed(bytes)?;
        let (joints, size, flags) = (rest.count()?, rest.count()?, rest.count()?);
        let (steps, advances) = (rest.count()?, rest.count()?);
        length("joints", joints as usize, N)?;
        let known = self.compensator.known_flags();
        if (flags ^ known) & KERNEL != 0 {
            let problem = "it belongs to a controller with a compensator of another kind: one of \
                           them has a dictionary";
            return Err(Error::damaged(problem));
        }
        length(self.compensator.entries(), size as usize, self.compensator.size())?;
        let common = if version == 1 { TORQUE } else { TORQUE | PENDING | FRONT };
        let uncounted = advances != 0 && !self.compensator.has_counter();
        if flags & !(known | common) != 0 || steps.max(advances) > MAX_COUNT || uncounted {
            return Err(Error::damaged("its header is not a possible one"));
        }
        let last_tau = last_torque(rest.vector()?, flags & TORQUE != 0)?;
        let origin = if version == 1 { Origin::Unknown } else { self.origin(&mut rest, other)? };
        let pending = if flags & PENDING != 0 { Some(self.pending(&mut rest)?) } else { None };
        let new = FrontMemory::new();
        let front = if flags & FRONT != 0 { FrontMemory::read(&mut rest)? } else { new };
        let same = origin == Origin::Same;
        let (pending, front) = (pending.filter(|_| same), if same { front } else { new });
        let part = rest.0;
        self.compensator.check(flags & !FRONT, part)?;
        Ok(Opened { origin, flags, steps, advances, last_tau, pending, front, part })
    }

    /// Whose fingerprints these are; another's are refused unless they are asked for.
    fn origin<S>(&self, rest: &mut Numbers<'_>, other: bool) -> Result<Origin>
    where
        C: Saves<N, S>,
    {
        let mut differs = [false; 4];
        for (differs, own) in differs.iter_mut().zip(self.fingerprints()) {
            *differs = rest.count()? != own;
        }
        let [arm, gains, compensator, basis] = differs;
        match differs {
            [false, false, false, false] => Ok(Origin::Same),
            _ if other => Ok(Origin::Other),
            _ => Err(Error::other_controller(arm, gains, compensator, basis)),
        }
    }

    fn pending(&self, rest: &mut Numbers<'_>) -> Result<Pending<N>> {
        let dt = rest.number()?;
        let mut vector = || rest.vector::<N>();
        let (asked, tau, q, dq) = (vector()?, vector()?, vector()?, vector()?);
        let desired = Setpoint { q: vector()?, dq: vector()?, ddq: vector()? };
        check_sample(&q, &dq, &desired)
            .and_then(|()| check_period("dt", dt))
            .map_err(|_| Error::damaged("its last sample is not a possible one"))?;
        if asked.iter().chain(&tau).any(|x| !x.is_finite()) {
            return Err(Error::damaged("its last torque is not finite"));
        }
        let sample = self.sample(&q, &dq, &desired);
        Ok(Pending { sample, applied: Applied::new(asked, tau), dt })
    }

    /// Takes what was checked. What the last step recorded is worked out again.
    fn take<S>(&self, state: &mut State<N, S>, saved: &Opened<'_, N>) -> Origin
    where
        C: Saves<N, S>,
    {
        let Opened { flags, steps, advances, last_tau, pending, front, part, .. } = *saved;
        let own = &mut state.compensator;
        self.compensator.take(own, flags, advances, part);
        if let Some(Pending { sample, .. }) = &pending {
            self.compensator.estimate(own, &Stage::NOW, sample);
        }
        (state.last_tau, state.steps) = (last_tau, steps);
        (state.pending, state.front) = (pending, front);
        saved.origin
    }
}

/// A dictionary, with its sets instead of the rules.
pub(super) const KERNEL: u64 = 8;

/// What saved bytes say.
struct Opened<'a, const N: usize> {
    origin: Origin,
    flags: u64,
    steps: u64,
    advances: u64,
    last_tau: Option<Vector<N>>,
    pending: Option<Pending<N>>,
    front: FrontMemory<N>,
    part: &'a [u8],
}

/// Checks checksum and magic; the version, and what follows it.
fn unsealed(bytes: &[u8]) -> Result<(u8, Numbers<'_>)> {
    let Some((body, sum)) = bytes.split_last_chunk::<8>() else {
        return Err(Error::damaged("it is too short"));
    };
    let version = body.strip_prefix(MAGIC).and_then(|rest| rest.split_first());
    let Some((version @ 1..=VERSION, rest)) = version else {
        return Err(Error::damaged("it was not saved by this version of steadyarm"));
    };
    if u64::from_le_bytes(*sum) != fnv(FNV_START, body) {
        return Err(Error::damaged("its checksum does not match: it was changed or cut"));
    }
    Ok((*version, Numbers(rest)))
}

fn last_torque<const N: usize>(tau: Vector<N>, known: bool) -> Result<Option<Vector<N>>> {
    if !tau.iter().all(|x| x.abs() <= IMPOSSIBLE) {
        return Err(Error::damaged("its last torque is not finite, or beyond 1e10"));
    }
    if !known && tau.iter().any(|x| *x != 0.0) {
        return Err(Error::damaged("it has a last torque, and says that it has none"));
    }
    Ok(known.then_some(tau))
}
