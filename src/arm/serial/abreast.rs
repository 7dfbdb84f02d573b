//! Chains side by side, a chain a lane.

use super::joint::{Chain, Joint, Mass};
use super::space::{Sym3, Turn, V3};
use crate::math::{Abreast, LANES, Vector};

impl<const N: usize> Chain<N, Abreast> {
    /// Chains whose joints are of the same kinds; `None` if they are not.
    pub fn abreast(each: [&Chain<N>; LANES]) -> Option<Self> {
        let [first, ..] = each;
        let kinds = |chain: &Chain<N>| chain.joints.each_ref().map(|joint| joint.revolute);
        each.iter().all(|chain| kinds(chain) == kinds(first)).then(|| Self {
            joints: core::array::from_fn(|i| joints(each.map(|chain| &chain.joints[i]))),
            base: first.base,
            tip: first.tip,
            gravity: vectors(each.map(|chain| &chain.gravity)),
            ground_energy: first.ground_energy,
        })
    }

    /// C q̇ + G.
    #[inline(always)]
    pub fn bias(&self, turns: &[Turn<Abreast>; N], dq: &Vector<N, Abreast>) -> Vector<N, Abreast> {
        let up = V3::zero_like(self.gravity.x) - self.gravity;
        self.inverse(turns, dq, None, up)
    }
}

fn joints(each: [&Joint; LANES]) -> Joint<Abreast> {
    let [first, ..] = each;
    Joint {
        revolute: first.revolute,
        rest: turns(each.map(|joint| &joint.rest)),
        mass: masses(each.map(|joint| &joint.mass)),
        armature: Abreast::of(each, |joint| joint.armature),
        friction: first.friction,
        user: first.user,
    }
}

fn vectors(each: [&V3; LANES]) -> V3<Abreast> {
    let of = |number: fn(&V3) -> f64| Abreast::of(each, number);
    V3::new(of(|v| v.x), of(|v| v.y), of(|v| v.z))
}

fn turns(each: [&Turn; LANES]) -> Turn<Abreast> {
    let of = |number: fn(&Turn) -> f64| Abreast::of(each, number);
    let p = vectors(each.map(|turn| &turn.p));
    Turn { ca: of(|it| it.ca), sa: of(|it| it.sa), c: of(|it| it.c), s: of(|it| it.s), p }
}

fn masses(each: [&Mass; LANES]) -> Mass<Abreast> {
    let of = |number: fn(&Sym3) -> f64| Abreast::of(each.map(|mass| &mass.sigma), number);
    Mass {
        m: Abreast::of(each, |mass| mass.m),
        h: vectors(each.map(|mass| &mass.h)),
        sigma: Sym3 {
            xx: of(|it| it.xx),
            yy: of(|it| it.yy),
            zz: of(|it| it.zz),
            xy: of(|it| it.xy),
            xz: of(|it| it.xz),
            yz: of(|it| it.yz),
        },
    }
}
