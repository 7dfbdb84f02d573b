//! What to read of a URDF, and the masses to put in the place of those that it states.

use std::collections::BTreeMap;

use super::elements::Document;
use super::link::{Inertial, LinkPart};
use super::tree::Tree;
use crate::arm::{Inertia, Unphysical};
use crate::robot::error::{listed, quoted};
use crate::robot::{GRAVITY, ReadError, checks};

/// What to read of a URDF, and what to put in the place of what it states.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfOptions {
    /// The link that stands still; the root by default.
    pub base: Option<String>,
    /// The link at the end of the chain; the only end of the robot by default.
    pub tip: Option<String>,
    /// Gravity in the axes of the file's root [m/s²].
    pub gravity: [f64; 3],
    /// Masses by link \[kg\]. Where the file states an `<inertial>`, its centre of mass stays. Its
    /// moments are scaled with the mass, as if the body had another density. Where the file states
    /// none, the body is uniform in the shape of `<collision>`, or else of `<visual>`, if that
    /// consists of boxes, cylinders and balls.
    pub masses: BTreeMap<String, f64>,
    /// Mass distributions by link, in the link's frame, in place of what the file states, if it
    /// states any.
    pub inertials: BTreeMap<String, Inertia>,
    /// What is done about a link that no rigid body can be, where a link is all that moves with a
    /// joint, together. A part that no body can be by itself is noted in any case.
    pub unphysical: Unphysical,
}

impl Default for UrdfOptions {
    fn default() -> Self {
        let (masses, inertials) = (BTreeMap::new(), BTreeMap::new());
        let unphysical = Unphysical::Refuse;
        Self { base: None, tip: None, gravity: GRAVITY, masses, inertials, unphysical }
    }
}

impl UrdfOptions {
    /// Refuses names that are no link, names given twice, and numbers that are none.
    pub(super) fn check(&self, tree: &Tree) -> Result<(), ReadError> {
        for (name, &mass) in &self.masses {
            tree.named("masses", name)?;
            let name = quoted(name);
            if !(mass > 0.0 && mass.is_finite()) {
                let message = format!("masses, {name}: got {mass} kg, wants a finite number > 0");
                return Err(ReadError::new(message));
            }
            if self.inertials.contains_key(name.trim_matches('"')) {
                let message = format!("masses, {name}: got it in inertials too, wants not both");
                return Err(ReadError::new(message));
            }
        }
        for (name, inertia) in &self.inertials {
            tree.named("inertials", name)?;
            let refused = |message: String| {
                Err(ReadError::new(format!("inertials, {}, {message}", quoted(name))))
            };
            if !(inertia.mass >= 0.0 && inertia.mass.is_finite()) {
                return refused(format!(
                    "mass: got {} kg, wants a finite number >= 0",
                    inertia.mass
                ));
            }
            if let Some(problem) = checks::form_problem(inertia) {
                return refused(problem);
            }
        }
        Ok(())
    }

    /// True if the mass distribution of this link is given.
    pub(super) fn gives(&self, link: &LinkPart) -> bool {
        self.masses.contains_key(link.name) || self.inertials.contains_key(link.name)
    }

    /// The mass distribution of a link that moves, and what its file's was replaced by.
    pub(super) fn inertial(
        &self,
        source: &Document,
        link: &LinkPart,
        notes: &mut Vec<String>,
    ) -> Result<Option<Inertial>, ReadError> {
        let owner = format!("link {}", quoted(link.name));
        if let Some(inertia) = self.inertials.get(link.name) {
            let stated = match link.inertial(source) {
                Ok(Some(stated)) => format!("{} kg of the file are not used", stated.inertia.mass),
                Ok(None) => "the file states none".to_owned(),
                Err(error) => format!("that of the file cannot be read ({})", error.message),
            };
            notes.push(format!("{owner}: inertial given, {} kg; {stated}", inertia.mass));
            return Ok(Some(Inertial::given(*inertia, link.at)));
        }
        let Some(&mass) = self.masses.get(link.name) else { return link.inertial(source) };
        let stated = link.inertial(source)?.filter(|stated| stated.inertia.mass > 0.0);
        if let Some(Inertial { inertia, .. }) = stated {
            let share = mass / inertia.mass;
            notes.push(format!(
                "{owner}: mass given, {mass} kg instead of {}; moments scaled by {share:.4}",
                inertia.mass
            ));
            let inertia = Inertia { mass, moments: inertia.moments * share, com: inertia.com };
            return Ok(Some(Inertial::given(inertia, link.at)));
        }
        let Some((inertia, shape)) = link.uniform(source, mass)? else {
            let message = format!(
                "{owner}: got {mass} kg in masses, but the file states no mass distribution to \
                 scale, nor a shape of boxes, cylinders and balls; give the centre of mass and the \
                 moments too, in inertials"
            );
            return Err(source.error(link.at, message));
        };
        notes.push(format!("{owner}: mass given, {mass} kg, uniform in the shape of <{shape}>"));
        Ok(Some(Inertial::given(inertia, link.at)))
    }

    /// A note on given masses of links that do not move with the chain.
    pub(super) fn unmoved<'a>(&'a self, moved: impl Fn(&str) -> bool) -> Option<String> {
        let names: Vec<&'a str> = self
            .masses
            .keys()
            .chain(self.inertials.keys())
            .map(String::as_str)
            .filter(|name| !moved(name))
            .collect();
        (!names.is_empty()).then(|| {
            let names = listed(names.into_iter());
            format!("masses given for links that do not move with the chain are not used: {names}")
        })
    }
}
