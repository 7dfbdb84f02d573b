//! What every description must be, whatever it was read from: links that an arm takes, with names
//! of their own. What is asked of a link stands with the arm; here it gets words and names.

use std::collections::BTreeSet;

use super::error::quoted;
use super::{Description, ReadError};
use crate::arm::{Flaw, Inertia, SYMMETRIC, Unphysical};
use crate::error::{Error, Problem, finite};

/// What is wrong, and at which joint.
pub(super) struct Refusal {
    pub joint: Option<usize>,
    /// Whether no rigid body can have the mass distribution.
    pub of_body: bool,
    pub message: String,
}

impl From<Refusal> for ReadError {
    fn from(refusal: Refusal) -> Self {
        Self::new(refusal.message)
    }
}

/// Takes the links as the description's `unphysical` says, and names in `notes` those that no rigid
/// body can be. Refuses what no arm can have.
pub(super) fn take(description: &mut Description) -> Result<(), Refusal> {
    let of_arm = |message| Refusal { joint: None, of_body: false, message };
    if description.joints.is_empty() {
        return Err(of_arm("joints: got none, wants at least one that moves".to_owned()));
    }
    let unphysical = description.unphysical;
    let of_whole = |error| of_arm(words(error));
    finite("gravity", &description.gravity).map_err(of_whole)?;
    let of_tip = |error| of_arm(format!("tip.{}", words(error)));
    description.tip.validate().map_err(of_tip)?;
    let mut names = BTreeSet::new();
    let mut said: BTreeSet<String> = description.notes.iter().cloned().collect();
    for (index, joint) in description.joints.iter_mut().enumerate() {
        let of_joint = |of_body, message: String| Refusal {
            joint: Some(index),
            of_body,
            message: format!("joint {}, {message}", quoted(&joint.name)),
        };
        if !names.insert(joint.name.as_str()) {
            return Err(of_joint(false, "name: given twice, wants a name of its own".to_owned()));
        }
        let stated = joint.link;
        let taken = stated.taken(index, unphysical);
        joint.link = taken.map_err(|error| match of_body(error, &stated.inertia) {
            Some(problem) => of_joint(true, problem + way_on(unphysical)),
            None => of_joint(false, words(error)),
        })?;
        let note = body_note(&joint.link_name, &stated.inertia, &joint.link.inertia);
        description.notes.extend(note.filter(|note| said.insert(note.clone())));
    }
    Ok(())
}

/// What is wrong with a mass distribution, if no rigid body can have it.
pub(super) fn body_problem(inertia: &Inertia) -> Option<String> {
    let flaw = inertia.flaw().ok().flatten()?;
    let wanted = flaw.wanted();
    Some(match flaw {
        Flaw::Mass(mass) => format!("mass: got {mass}, wants {wanted}"),
        Flaw::Massless => format!("mass: got 0, wants {wanted}"),
        Flaw::Moments(principal) => {
            format!("moments: got principal moments {} kg m^2, wants {wanted}", figures(&principal))
        }
    })
}

/// What is wrong with numbers that are no mass distribution at all: not finite, not symmetric.
pub(super) fn form_problem(inertia: &Inertia) -> Option<String> {
    inertia.check_form().err().map(words)
}

/// What a refusal says of the way on.
pub(super) fn way_on(unphysical: Unphysical) -> &'static str {
    match unphysical {
        Unphysical::Refuse => {
            "; unphysical = \"note\" takes it as it stands, \"nearest\" the nearest body"
        }
        _ => "",
    }
}

/// How far from a body's a mass distribution is.
pub(super) fn how_far(inertia: &Inertia) -> Option<String> {
    Some(match inertia.flaw().ok().flatten()? {
        Flaw::Mass(mass) => format!("a mass of {mass} kg"),
        Flaw::Massless => "moments without mass".to_owned(),
        Flaw::Moments(principal) => {
            let [least, middle, most] = principal;
            format!(
                "principal moments {} kg m^2, of which the largest is {:.3e} kg m^2 more than the \
                 sum of the other two",
                figures(&principal),
                most - (least + middle)
            )
        }
    })
}

/// The note on a link that no rigid body can be: taken as stated, or what it became.
fn body_note(link: &str, stated: &Inertia, taken: &Inertia) -> Option<String> {
    let link = quoted(link);
    let how_far = how_far(stated)?;
    if stated == taken {
        return Some(format!("link {link}: taken as stated, though no body has {how_far}"));
    }
    let nearest = taken.principal_moments().unwrap_or_default();
    Some(format!(
        "link {link}: no body has {how_far}; taken as the nearest, of principal moments {} kg m^2",
        figures(&nearest)
    ))
}

/// Notes on links that are taken as stated, though no rigid body can be like that.
pub(super) fn as_stated(description: &Description) -> Vec<String> {
    let joints = description.joints.iter();
    joints
        .filter_map(|joint| {
            let inertia = &joint.link.inertia;
            body_note(&joint.link_name, inertia, inertia)
        })
        .collect()
}

/// `1.0000e-1, 2.0000e-1, 3.1000e-1`.
fn figures(values: &[f64; 3]) -> String {
    values.map(|value| format!("{value:.4e}")).join(", ")
}

/// The arm's complaint about a mass distribution that no rigid body can have, if that is what it
/// is.
fn of_body(error: Error, inertia: &Inertia) -> Option<String> {
    let of_body = matches!(error.parameter(), "inertia.moments" | "inertia.mass");
    match error.problem() {
        Problem::OutOfRange { wanted, .. } if of_body && wanted != SYMMETRIC => {
            body_problem(inertia)
        }
        _ => None,
    }
}

/// The arm's complaint without the joint's number, in the names of a description.
fn words(error: Error) -> String {
    if let Problem::OutOfRange { got, wanted: SYMMETRIC } = error.problem() {
        return format!(
            "moments: got a matrix that is not symmetric, by {got:.1e}, wants a symmetric one"
        );
    }
    let parameter = error.parameter();
    let name = parameter.strip_prefix("inertia.").unwrap_or(parameter);
    error.named(name).at(None).to_string()
}

/// The complaint of the whole arm, with the joint by its name.
pub(super) fn of_arm(description: &Description, error: Error) -> String {
    let index = error.index().filter(|_| error.parameter() != "gravity");
    let Some(joint) = index.and_then(|index| description.joints.get(index)) else {
        return error.to_string();
    };
    let (name, link) = (quoted(&joint.name), quoted(&joint.link_name));
    format!("joint {name}, link {link} with what hangs on it, {}", words(error))
}
