//! Three-vectors, and the turn from one link's frame to the next, `R = R_x(α) R_z(θ)`.

use core::ops::{Add, AddAssign, Mul, Sub};

use crate::math::{Matrix, Real};

/// A vector in some link's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct V3<T = f64> {
    pub x: T,
    pub y: T,
    pub z: T,
}

impl<T> V3<T> {
    #[inline(always)]
    pub const fn new(x: T, y: T, z: T) -> Self {
        Self { x, y, z }
    }
}

impl<T: Real> V3<T> {
    /// self × z.
    #[inline(always)]
    pub fn cross_z(self) -> Self {
        Self::new(self.y, -self.x, self.z.like(0.0))
    }

    /// Zero, in numbers of the kind of `x`.
    #[inline(always)]
    pub fn zero_like(x: T) -> Self {
        let zero = x.like(0.0);
        Self::new(zero, zero, zero)
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// A v.
    #[inline(always)]
    pub fn rotated(self, a: &Matrix<3>) -> Self {
        let row = |i: usize| [a[(i, 0)], a[(i, 1)], a[(i, 2)]];
        Self::new(self.along(row(0)), self.along(row(1)), self.along(row(2)))
    }

    #[inline(always)]
    fn along(self, [x, y, z]: [f64; 3]) -> T {
        self.x.like(x) * self.x + self.x.like(y) * self.y + self.x.like(z) * self.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }
}

impl V3 {
    pub const ZERO: Self = Self::new(0.0, 0.0, 0.0);

    pub fn to_na(self) -> nalgebra::Vector3<f64> {
        nalgebra::Vector3::new(self.x, self.y, self.z)
    }
}

impl From<nalgebra::Vector3<f64>> for V3 {
    #[inline]
    fn from(v: nalgebra::Vector3<f64>) -> Self {
        Self::new(v[0], v[1], v[2])
    }
}

impl<T: Real> Add for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<T: Real> AddAssign for V3<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Real> Sub for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<T: Real> Mul<T> for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: T) -> Self {
        Self::new(self.x * by, self.y * by, self.z * by)
    }
}

/// A link's frame in the frame of the link before, at some q: `x_before = R_x(α) R_z(θ) x + p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turn<T = f64> {
    /// cos α and sin α.
    pub ca: T,
    pub sa: T,
    /// cos θ and sin θ.
    pub c: T,
    pub s: T,
    pub p: V3<T>,
}

impl<T: Real> Turn<T> {
    /// Rᵀ v: the vector of the frame before, in this one.
    #[inline(always)]
    pub fn outward(&self, v: V3<T>) -> V3<T> {
        let y = self.ca * v.y + self.sa * v.z;
        let z = self.ca * v.z - self.sa * v.y;
        V3::new(self.c * v.x + self.s * y, self.c * y - self.s * v.x, z)
    }

    /// R v: the vector of this frame, in the one before.
    #[inline(always)]
    pub fn inward(&self, v: V3<T>) -> V3<T> {
        let x = self.c * v.x - self.s * v.y;
        let y = self.s * v.x + self.c * v.y;
        V3::new(x, self.ca * y - self.sa * v.z, self.sa * y + self.ca * v.z)
    }

    /// R(B) = B R_x R_z for the columns of a rotation B.
    #[inline(always)]
    pub fn columns(&self, [x, y, z]: [V3<T>; 3]) -> [V3<T>; 3] {
        let turned = y * self.ca + z * self.sa;
        let axis = z * self.ca - y * self.sa;
        [x * self.c + turned * self.s, turned * self.c - x * self.s, axis]
    }
}

/// A symmetric 3×3 matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sym3<T = f64> {
    pub xx: T,
    pub yy: T,
    pub zz: T,
    pub xy: T,
    pub xz: T,
    pub yz: T,
}

impl Sym3 {
    pub const ZERO: Self = Self { xx: 0.0, yy: 0.0, zz: 0.0, xy: 0.0, xz: 0.0, yz: 0.0 };

    /// The symmetric part of `a`.
    pub fn of(a: &Matrix<3>) -> Self {
        let half = |i, j| 0.5 * (a[(i, j)] + a[(j, i)]);
        Self {
            xx: a[(0, 0)],
            yy: a[(1, 1)],
            zz: a[(2, 2)],
            xy: half(0, 1),
            xz: half(0, 2),
            yz: half(1, 2),
        }
    }
}

impl<T: Real> Sym3<T> {
    /// R S Rᵀ with R = R_x R_z.
    #[inline(always)]
    pub fn inward(&self, turn: &Turn<T>) -> Self {
        // R_z turns the xy block and the pair (xz, yz); R_x then the yz block and the pair (xy,
        // xz).
        let (c, s) = (turn.c, turn.s);
        let (xx, yy, xy) = turned_block(self.xx, self.yy, self.xy, c, s);
        let xz = c * self.xz - s * self.yz;
        let yz = s * self.xz + c * self.yz;
        let (ca, sa) = (turn.ca, turn.sa);
        let (yy, zz, yz) = turned_block(yy, self.zz, yz, ca, sa);
        Self { xx, yy, zz, yz, xy: ca * xy - sa * xz, xz: sa * xy + ca * xz }
    }
}

impl<T: Real> Add for Sym3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self {
            xx: self.xx + o.xx,
            yy: self.yy + o.yy,
            zz: self.zz + o.zz,
            xy: self.xy + o.xy,
            xz: self.xz + o.xz,
            yz: self.yz + o.yz,
        }
    }
}

/// [c −s; s c] [a o; o b] [c s; −s c], as (a, b, o).
#[inline(always)]
fn turned_block<T: Real>(a: T, b: T, o: T, c: T, s: T) -> (T, T, T) {
    let (cs, ss) = (c * s, s * s);
    let gap = a - b;
    let moved = ss * gap + (cs + cs) * o;
    (a - moved, b + moved, cs * gap + (c * c - ss) * o)
}
