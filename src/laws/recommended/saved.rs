//! What was learnt as bytes: θ · P, lower triangle · LP[Φ] · columns of the last samples · filters
//! · what was decided in the last samples.

use super::learned_torque::LearnedTorque;
use super::memory::{Decided, Filtered, LearnedTorqueState};
use crate::arm::Parametric;
use crate::control::{MAX_DELAY, Numbers, Saves, put_all};
use crate::error::{Error, Result, finite};
use crate::fuzzy::Buffer;
use crate::math::fnv_of;

const FROZEN: u64 = 1;
/// How far an entry of P may be beyond what a covariance can have, relative.
const ROUNDING: f64 = 1e-9;

impl<const N: usize, const K: usize, A, B> Saves<N, LearnedTorqueState<N, B>>
    for LearnedTorque<N, K, A>
where
    A: Parametric<N, K>,
    B: Buffer,
{
    fn known_flags(&self) -> u64 {
        FROZEN
    }

    fn entries(&self) -> &'static str {
        "parameters"
    }

    fn size(&self) -> usize {
        self.features.shape.parameters()
    }

    fn fingerprints(&self) -> [u64; 2] {
        let gains = &self.gains;
        let one = [gains.learning, gains.acceleration_share, gains.control_period];
        let all = gains.cut_off.iter().chain(&gains.unit).chain(&one).copied();
        let update = fnv_of(gains.pull.fingerprint(), all.chain([gains.delay as f64]));
        [update, self.features.fingerprint()]
    }

    fn flags(&self, state: &LearnedTorqueState<N, B>) -> u64 {
        if state.frozen { FROZEN } else { 0 }
    }

    fn has_counter(&self) -> bool {
        true
    }

    fn advances(&self, state: &LearnedTorqueState<N, B>) -> u64 {
        state.periods
    }

    fn write(&self, state: &LearnedTorqueState<N, B>, put: &mut dyn FnMut(&[u8])) {
        let [theta, p, rest] = self.kept(state.memory.as_slice());
        put_all(put, theta);
        for (k, row) in p.chunks_exact(self.features.shape.stride()).enumerate() {
            put_all(put, &row[..=k]);
        }
        put_all(put, rest);
        let it = &state.filtered;
        let vectors = [&it.velocity, &it.slow, &it.zeta, &it.torque, &it.momentum, &it.rest];
        vectors.into_iter().for_each(|part| put_all(put, part.as_slice()));
        put_all(put, &[it.period, it.since, it.astray]);
        for Decided { torque, v, dq } in &state.decided {
            [torque, v, dq].into_iter().for_each(|part| put_all(put, part.as_slice()));
        }
    }

    fn check(&self, _: u64, part: &[u8]) -> Result<()> {
        let (mut rest, count) = (Numbers(part), self.features.shape.parameters());
        for number in rest.iter() {
            finite("parameters", &[number])?;
        }
        rest.split(count)?;
        let mut largest = self.features.prior();
        for k in 0..count {
            let prior = largest.next().unwrap_or(0.0);
            let row = rest.split(k + 1)?;
            let own = row.iter().last().unwrap_or(0.0);
            if !(0.0..=prior * (1.0 + ROUNDING)).contains(&own) {
                return Err(Error::damaged("its spread is larger than it was at the start"));
            }
            for (entry, other) in row.iter().zip(self.features.prior()) {
                if entry * entry > own * other * (1.0 + ROUNDING) {
                    return Err(Error::damaged("its spread is not a possible one"));
                }
            }
        }
        rest.split(self.columns_kept())?;
        let (filtered, _) = signals::<N>(&mut rest)?;
        let timed = [filtered.period, filtered.since].iter().all(|time| *time >= 0.0);
        if !timed {
            return Err(Error::damaged("its times are not possible ones"));
        }
        rest.end()
    }

    fn take(&self, state: &mut LearnedTorqueState<N, B>, flags: u64, periods: u64, part: &[u8]) {
        self.begin(state);
        let (mut saved, stride) = (Numbers(part), self.features.shape.stride());
        let (count, memory) = (self.features.shape.parameters(), state.memory.as_mut_slice());
        let mut next = || saved.number().unwrap_or(0.0);
        let (theta, rest) = memory.split_at_mut(stride);
        theta[..count].fill_with(&mut next);
        let (p, rest) = rest.split_at_mut(stride * count);
        for k in 0..count {
            for j in 0..=k {
                let entry = next();
                (p[k * stride + j], p[j * stride + k]) = (entry, entry);
            }
        }
        rest[stride..][..self.columns_kept()].fill_with(&mut next);
        if let Ok((filtered, decided)) = signals(&mut saved) {
            (state.filtered, state.decided) = (filtered, decided);
        }
        (state.periods, state.frozen) = (periods, flags & FROZEN != 0);
    }
}

type Signals<const N: usize> = (Filtered<N>, [Decided<N>; MAX_DELAY + 1]);

fn signals<const N: usize>(rest: &mut Numbers<'_>) -> Result<Signals<N>> {
    let mut vector = || rest.vector::<N>();
    let [velocity, slow, zeta] = [vector()?, vector()?, vector()?];
    let [torque, momentum, resting] = [vector()?, vector()?, vector()?];
    let [period, since, astray] = [rest.number()?, rest.number()?, rest.number()?];
    let filtered =
        Filtered { velocity, slow, zeta, torque, momentum, rest: resting, period, since, astray };
    let mut decided = [Decided::nothing(0.0); MAX_DELAY + 1];
    for Decided { torque, v, dq } in &mut decided {
        (*torque, *v, *dq) = (rest.vector()?, rest.vector()?, rest.vector()?);
    }
    Ok((filtered, decided))
}
