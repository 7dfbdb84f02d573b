//! The rooms of the house: a file imports from lower floors only, and no file is too long.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const FLOORS: [&[&str]; 6] = [
    &["error", "math", "eigen"],
    &["riccati", "fuzzy", "reference", "arm"],
    &["control", "plant", "robot"],
    &["sim", "design"],
    &["paper"],
    &["python"],
];

/// Imports within a floor, in one direction each: eigenvalues need vectors and errors, actuators have a controller's limits.
const NEIGHBOURS: [(&str, &str); 3] = [("eigen", "error"), ("eigen", "math"), ("plant", "control")];

const MOST_LINES: usize = 400;

struct Source {
    path: PathBuf,
    room: String,
    text: String,
}

/// Every file of src but lib.rs, with the room it stands in.
fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    collect(&root, &root, &mut found);
    assert!(found.len() > 30);
    found
}

fn collect(root: &Path, directory: &Path, found: &mut Vec<Source>) {
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(root, &path, found);
        } else if path.extension().is_some_and(|e| e == "rs") && path != root.join("lib.rs") {
            let first = path.strip_prefix(root).unwrap().components().next().unwrap();
            let name = Path::new(first.as_os_str()).file_stem().unwrap();
            let room = name.to_str().unwrap().to_owned();
            found.push(Source { text: fs::read_to_string(&path).unwrap(), path, room });
        }
    }
}

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&room))
}

/// The rooms named after `crate::` anywhere outside comments: `use crate::a::b`, `use crate::{a, b}`, `crate::a::f()`.
fn rooms_used(text: &str) -> BTreeSet<String> {
    let code: String = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let mut rooms = BTreeSet::new();
    for (_, after) in
        code.match_indices("crate::").map(|(at, found)| code.split_at(at + found.len()))
    {
        match after.strip_prefix('{') {
            Some(group) => rooms.extend(heads_of_group(group)),
            None => rooms.extend(head(after)),
        }
    }
    rooms
}

/// The first names of `a::{x, y}, b, c::z}`.
fn heads_of_group(group: &str) -> Vec<String> {
    let (mut depth, mut heads, mut start) = (0, Vec::new(), 0);
    for (at, sign) in group.char_indices() {
        match sign {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                heads.extend(head(group[start..at].trim()));
                start = at + 1;
                if sign == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    heads
}

/// The leading name, if it is a room's: types at the top of the crate come from error.
fn head(path: &str) -> Option<String> {
    let name: String = path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    match name.as_str() {
        "" => None,
        "Error" | "Result" => Some("error".to_owned()),
        _ => Some(name),
    }
}

#[test]
fn imports_are_found_in_every_form() {
    let text = "use crate::a::X;\nuse crate::{b::{Y, Z}, c,\n    d::e};\n// crate::f\nlet x = crate::g::h();\nuse crate::Error;";
    let found: Vec<_> = rooms_used(text).into_iter().collect();
    assert_eq!(found, ["a", "b", "c", "d", "error", "g"]);
}

#[test]
fn every_file_stands_in_a_known_room() {
    for Source { path, room, .. } in sources() {
        assert!(floor(&room).is_some(), "{} belongs to no floor", path.display());
    }
}

#[test]
fn files_import_from_lower_floors_only() {
    for Source { path, room, text } in sources() {
        for used in rooms_used(&text) {
            let (own, other) = (floor(&room), floor(&used));
            assert!(other.is_some(), "{}: crate::{used} is no room", path.display());
            let allowed = used == room || NEIGHBOURS.contains(&(&room, &used)) || other < own;
            assert!(allowed, "{} (floor {own:?}) uses {used} (floor {other:?})", path.display());
        }
    }
}

/// Files of a kind of room that are too long.
fn too_long(of_kind: impl Fn(&str) -> bool) -> Vec<(PathBuf, usize)> {
    let lengths = sources().into_iter().filter(|source| of_kind(&source.room));
    let lengths = lengths.map(|source| (source.path, source.text.lines().count()));
    lengths.filter(|(_, lines)| *lines > MOST_LINES).collect()
}

#[test]
fn no_file_is_longer_than_the_ceiling() {
    assert_eq!(too_long(|room| room != "python"), []);
}

#[test]
fn no_file_of_the_binding_is_longer_than_the_ceiling() {
    assert_eq!(too_long(|room| room == "python"), []);
}

/// Only the python room may know of Python, and it is gated once.
#[test]
fn only_one_room_knows_python() {
    let of_python = |text: &str| text.contains("pyo3") || text.contains("numpy");
    for Source { path, room, text } in sources() {
        assert!(room == "python" || !of_python(&text), "{}", path.display());
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs");
    let gates = fs::read_to_string(root).unwrap().matches("feature = \"python\"").count();
    assert!(gates <= 1, "{gates} gates");
}
