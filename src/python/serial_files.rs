//! Robot descriptions from Python's arguments: paths, texts, and tables.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};

use super::convert::{
    Any, Numbers, matrix_of, numbers, object, scalar, word, wrong_shape, wrong_type,
};
use super::dispatch::MAX_JOINTS;
use super::saving;
use crate::arm::{Inertia, JointFriction, JointKind, Link, Unphysical};
use crate::math::Matrix;
use crate::robot::{Convention, Description, DhRow, GRAVITY, UrdfOptions};

/// A description's source.
enum TextOrPath {
    Text(String),
    Path(PathBuf),
}

/// A string is the text itself if it says so, and otherwise a path.
fn source(value: Any<'_, '_>, is_text: impl Fn(&str) -> bool) -> PyResult<TextOrPath> {
    if let Ok(text) = value.cast::<PyString>() {
        let text: String = text.extract()?;
        if is_text(&text) {
            return Ok(TextOrPath::Text(text));
        }
    }
    let path: PathBuf =
        value.extract().map_err(|_| wrong_type("path_or_text", value, "a path or the text"))?;
    saving::exists(&path)?;
    Ok(TextOrPath::Path(path))
}

pub(super) fn urdf(value: Any<'_, '_>, options: &UrdfOptions) -> PyResult<Description> {
    match source(value, |text| text.trim_start_matches('\u{feff}').trim_start().starts_with('<'))? {
        TextOrPath::Text(text) => Description::from_urdf_with(&text, options),
        TextOrPath::Path(path) => Description::from_urdf_file_with(path, options),
    }
    .map_err(PyErr::from)
}

/// What is done about links that no body is stands in the file, unless it is given.
pub(super) fn toml(value: Any<'_, '_>, policy: Option<Any<'_, '_>>) -> PyResult<Description> {
    let policy = unphysical(policy)?;
    let read = |text: &str| match policy {
        Some(policy) => Description::from_toml_taking(text, policy),
        None => Description::from_toml(text),
    };
    match source(value, |text| text.contains('\n'))? {
        TextOrPath::Text(text) => read(&text),
        TextOrPath::Path(path) => Description::from_file(path, read),
    }
    .map_err(PyErr::from)
}

/// From a table.
pub(super) fn dh(
    columns: &Columns<'_, '_>,
    convention: Option<Any<'_, '_>>,
    gravity_of: Option<Any<'_, '_>>,
    name: &str,
    policy: Option<Any<'_, '_>>,
) -> PyResult<Description> {
    let (gravity, policy) = (gravity(gravity_of)?, unphysical(policy)?.unwrap_or_default());
    let (rows, convention) = (dh_rows(columns)?, self::convention(convention)?);
    Ok(Description::from_dh_taking(name, &rows, convention, gravity, policy)?)
}

/// The usual one, unless it is given.
pub(super) fn gravity(value: Option<Any<'_, '_>>) -> PyResult<[f64; 3]> {
    value.map_or(Ok(GRAVITY), |value| triple(value, "gravity"))
}

/// What is done about links that no body is, if it is said.
pub(super) fn unphysical(value: Option<Any<'_, '_>>) -> PyResult<Option<Unphysical>> {
    let all = [Unphysical::Refuse, Unphysical::Note, Unphysical::Nearest];
    value.map(|value| word(value, "unphysical", all.map(|it| (it.name(), it)))).transpose()
}

/// Refuses stops for an arm whose joints have no ends.
pub(super) fn refuse_stops_without_ends(links: &[Link], stiffness: &[f64]) -> PyResult<()> {
    let ends = links
        .iter()
        .any(|Link { limits, .. }| limits.lower.is_finite() || limits.upper.is_finite());
    match stiffness.iter().find(|&&k| k > 0.0).filter(|_| !ends) {
        None => Ok(()),
        Some(got) => Err(PyValueError::new_err(format!(
            "stiffness: got {got} for an arm whose joints have no ends, wants one with limits, \
             from a URDF or TOML"
        ))),
    }
}

/// `{link: kg}`.
pub(super) fn masses(value: Option<Any<'_, '_>>) -> PyResult<BTreeMap<String, f64>> {
    by_link(value, "masses", "a dict of masses by link", |mass, name| scalar(&mass, name))
}

/// `{link: (mass, com, moments)}`.
pub(super) fn inertials(value: Option<Any<'_, '_>>) -> PyResult<BTreeMap<String, Inertia>> {
    let wanted = "a dict of (mass, com, moments) by link";
    by_link(value, "inertials", wanted, |parts, name| {
        let parts = parts.extract::<[Bound<'_, PyAny>; 3]>();
        let [mass, com, moments_of] = parts
            .map_err(|_| PyValueError::new_err(format!("{name}: wants (mass, com, moments)")))?;
        Ok(Inertia {
            mass: scalar(&mass, &format!("{name}, mass"))?,
            com: triple(&com, &format!("{name}, com"))?.into(),
            moments: moments(&moments_of, &format!("{name}, moments"))?,
        })
    })
}

/// A mapping by the names of links; nothing where it is absent.
fn by_link<'py, T>(
    value: Option<Any<'_, 'py>>,
    argument: &str,
    wanted: &str,
    read: impl Fn(Bound<'py, PyAny>, &str) -> PyResult<T>,
) -> PyResult<BTreeMap<String, T>> {
    let Some(value) = value else { return Ok(BTreeMap::new()) };
    let mapping = object::<PyMapping>(value, argument, wanted)?;
    let mut found = BTreeMap::new();
    for item in mapping.items()?.iter() {
        let (key, value) = item.extract::<(Bound<'py, PyAny>, Bound<'py, PyAny>)>()?;
        let link: String =
            key.extract().map_err(|_| wrong_type(argument, &key, "names of links"))?;
        let read = read(value, &format!("{argument}[{link:?}]"))?;
        found.insert(link, read);
    }
    Ok(found)
}

/// Three numbers.
pub(super) fn triple(value: Any<'_, '_>, name: &str) -> PyResult<[f64; 3]> {
    let list = numbers(value, name)?;
    match <[f64; 3]>::try_from(list.values) {
        Ok(values) if list.shape.len() == 1 => Ok(values),
        _ => Err(wrong_shape(name, &list.shape, "(3,)")),
    }
}

/// Moments of inertia: the same about all axes, a diagonal, or a matrix.
pub(super) fn moments(value: Any<'_, '_>, name: &str) -> PyResult<Matrix<3>> {
    let list = numbers(value, name)?;
    match list.shape[..] {
        [] => Ok(Matrix::<3>::from_diagonal_element(list.values[0])),
        [3] => Ok(Matrix::<3>::from_diagonal(&triple(value, name)?.into())),
        [3, 3] => Ok(Matrix::<3>::from_row_slice(&matrix_of(value, name, 3, 3)?)),
        _ => Err(wrong_shape(name, &list.shape, "a scalar, (3,) or (3, 3)")),
    }
}

/// "standard" by default.
fn convention(value: Option<Any<'_, '_>>) -> PyResult<Convention> {
    let all = [("standard", Convention::Standard), ("modified", Convention::Modified)];
    value.map_or(Ok(Convention::Standard), |value| word(value, "convention", all))
}

/// Columns of a Denavit-Hartenberg table: a value a joint, or one for all.
pub(super) struct Columns<'a, 'py> {
    /// a, alpha, d, theta_offset.
    pub lengths: [Option<Any<'a, 'py>>; 4],
    pub kind: Option<Any<'a, 'py>>,
    pub mass: Option<Any<'a, 'py>>,
    pub com: Option<Any<'a, 'py>>,
    pub inertia: Option<Any<'a, 'py>>,
    /// viscous, coulomb, armature.
    pub joint: [Option<Any<'a, 'py>>; 3],
}

/// A column of numbers: for every joint a number, a vector of 3 or a matrix of 3 × 3.
struct Column {
    name: &'static str,
    numbers: Option<Numbers>,
}

impl Column {
    fn new(value: Option<Any<'_, '_>>, name: &'static str) -> PyResult<Self> {
        Ok(Self { name, numbers: value.map(|value| numbers(value, name)).transpose()? })
    }

    /// The rows that it has, if it is no scalar.
    fn rows(&self) -> Option<usize> {
        self.numbers.as_ref()?.shape.first().copied()
    }

    /// The entry of a joint out of so many, of one of these ranks; or the one number of a scalar.
    fn of(&self, joint: usize, joints: usize, ranks: &[usize]) -> PyResult<&[f64]> {
        let Some(Numbers { shape, values }) = &self.numbers else { return Ok(&[0.0]) };
        match &shape[..] {
            [] => Ok(values),
            [rows, entry @ ..]
                if *rows == joints
                    && ranks.contains(&entry.len())
                    && entry.iter().all(|&size| size == 3) =>
            {
                let size = values.len() / joints;
                Ok(&values[joint * size..(joint + 1) * size])
            }
            _ => {
                let entry = |&rank: &usize| if rank == 0 { ",".into() } else { ", 3".repeat(rank) };
                let shapes = ranks.iter().map(|rank| format!("({joints}{})", entry(rank)));
                let wanted = shapes.collect::<Vec<_>>().join(" or ");
                Err(wrong_shape(self.name, shape, &format!("a scalar or {wanted}")))
            }
        }
    }
}

/// The rows of the table.
fn dh_rows(columns: &Columns<'_, '_>) -> PyResult<Vec<DhRow>> {
    let mut scalars = Vec::new();
    let names = ["a", "alpha", "d", "theta_offset"].into_iter().zip(columns.lengths);
    let more = ["viscous", "coulomb", "armature"].into_iter().zip(columns.joint);
    for (name, value) in names.chain(more).chain([("mass", columns.mass)]) {
        scalars.push(Column::new(value, name)?);
    }
    let com = Column::new(columns.com, "com")?;
    let inertia = Column::new(columns.inertia, "inertia")?;
    let rows = scalars.iter().chain([&com, &inertia]).find_map(Column::rows).unwrap_or(1);
    if rows == 0 || rows > MAX_JOINTS {
        return Err(super::dispatch::too_many_joints(rows));
    }
    let kinds = kinds(columns.kind, rows)?;
    let row = |(joint, kind)| dh_row(&scalars, [&com, &inertia], (joint, rows), kind);
    kinds.into_iter().enumerate().map(row).collect()
}

/// The row of a joint out of so many.
fn dh_row(
    scalars: &[Column],
    [com, inertia]: [&Column; 2],
    (joint, joints): (usize, usize),
    kind: JointKind,
) -> PyResult<DhRow> {
    let mut row = [0.0; 8];
    for (entry, column) in row.iter_mut().zip(scalars) {
        *entry = column.of(joint, joints, &[0])?[0];
    }
    let [a, alpha, d, theta_offset, viscous, coulomb, armature, mass] = row;
    let com = match *com.of(joint, joints, &[1])? {
        [x, y, z] => [x, y, z],
        ref same => [same[0]; 3],
    };
    let moments = match *inertia.of(joint, joints, &[1, 2])? {
        [same] => Matrix::<3>::from_diagonal_element(same),
        [x, y, z] => Matrix::<3>::from_diagonal(&[x, y, z].into()),
        ref matrix => Matrix::<3>::from_row_slice(matrix),
    };
    let inertia = Inertia { mass, com: com.into(), moments };
    let friction = JointFriction { viscous, coulomb: [coulomb; 2], ..Default::default() };
    Ok(DhRow { kind, a, alpha, d, theta_offset, inertia, friction, armature, ..DhRow::default() })
}

/// "revolute", "continuous" or "prismatic", for all joints or each.
fn kinds(value: Option<Any<'_, '_>>, joints: usize) -> PyResult<Vec<JointKind>> {
    let all = [JointKind::Revolute, JointKind::Continuous, JointKind::Prismatic];
    let kind = |value: Any<'_, '_>| word(value, "kind", all.map(|it| (it.name(), it)));
    let Some(value) = value else { return Ok(vec![JointKind::Revolute; joints]) };
    if value.is_instance_of::<PyString>() {
        return Ok(vec![kind(value)?; joints]);
    }
    let words = value.try_iter().map_err(|_| wrong_type("kind", value, "a word or a list"))?;
    let kinds: Vec<JointKind> = words.map(|word| kind(&word?)).collect::<PyResult<_>>()?;
    if kinds.len() != joints {
        let got = kinds.len();
        let message =
            format!("kind: got {got} words, wants one, or one for each of {joints} joints");
        return Err(PyValueError::new_err(message));
    }
    Ok(kinds)
}
