//! The rooms of the house: a file imports from lower floors only, files do not need each other in a
//! circle, and no file or line is too long.

mod circles;
mod names;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use names::{names, tokens};

const FLOORS: [&[&str]; 7] = [
    &["error", "math", "eigen"],
    &["riccati", "fuzzy", "reference", "arm"],
    &["control", "effects", "plant", "robot"],
    &["sim", "design", "laws"],
    &["paper"],
    &["scenario"],
    &["python"],
];

/// Imports within a floor, in one direction each: eigenvalues need vectors and errors,
/// actuators have a controller's limits, and the loop its delay.
const NEIGHBOURS: [(&str, &str); 5] = [
    ("eigen", "error"),
    ("eigen", "math"),
    ("effects", "control"),
    ("effects", "plant"),
    ("plant", "control"),
];

const MOST_LINES: usize = 400;

/// Columns of a line.
const WIDEST: usize = 100;

/// Lines of the binding that are wider, and may not become more.
const MOST_LONG_LINES_OF_THE_BINDING: usize = 3;

struct Source {
    /// Below src.
    below: PathBuf,
    room: String,
    text: String,
}

/// Every file of src, with the room it stands in; that of lib.rs has no floor.
fn files() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let of_rust = below(&root).into_iter().map(|path| {
        let below = path.strip_prefix(&root).unwrap().to_owned();
        let room = Path::new(below.iter().next().unwrap()).file_stem().unwrap();
        let room = room.to_str().unwrap().to_owned();
        Source { text: fs::read_to_string(path).unwrap(), below, room }
    });
    of_rust.collect()
}

/// Every file of src but lib.rs.
fn sources() -> Vec<Source> {
    let mut sources = files();
    sources.retain(|source| source.room != "lib");
    assert!(sources.len() > 30);
    sources
}

/// The files of Rust below a folder.
fn below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let found = entries.flat_map(|path| {
        if path.is_dir() && !path.ends_with("target") { below(&path) } else { vec![path] }
    });
    found.filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&room))
}

/// The rooms that a text names: types at the top of the crate come from error.
fn rooms_used(text: &str) -> BTreeSet<String> {
    let tokens = tokens(text);
    let names = names(&tokens).into_iter().filter(|name| name.path[0] == "crate");
    let rooms = names.filter_map(|name| match *name.path.get(1)? {
        "Error" | "Result" => Some("error".to_owned()),
        room => Some(room.to_owned()),
    });
    rooms.collect()
}

#[test]
fn imports_are_found_in_every_form() {
    let text = "use crate::a::X;\nuse crate::{b::{Y, Z}, c,\n    d::e};\n\
                // crate::f\nlet x = crate::g::h();\nuse crate::Error;";
    // crate::f\nlet x = crate::g::h();\nuse crate::Error;";
    let found: Vec<_> = rooms_used(text).into_iter().collect();
    assert_eq!(found, ["a", "b", "c", "d", "error", "g"]);
}

#[test]
fn every_file_stands_in_a_known_room() {
    for Source { below, room, .. } in sources() {
        assert!(floor(&room).is_some(), "{} belongs to no floor", below.display());
    }
}

#[test]
fn files_import_from_lower_floors_only() {
    for Source { below, room, text } in sources() {
        for used in rooms_used(&text) {
            let (own, other) = (floor(&room), floor(&used));
            assert!(other.is_some(), "{}: crate::{used} is no room", below.display());
            // Tests may use what stands on the same floor.
            let of_tests = below.to_string_lossy().contains("/tests");
            let lower = other < own || of_tests && other == own;
            let allowed = used == room || NEIGHBOURS.contains(&(&room, &used)) || lower;
            assert!(allowed, "{} (floor {own:?}) uses {used} (floor {other:?})", below.display());
        }
    }
}

/// Files of a kind of room that are too long.
fn too_long(of_kind: impl Fn(&str) -> bool) -> Vec<(PathBuf, usize)> {
    let lengths = sources().into_iter().filter(|source| of_kind(&source.room));
    let lengths = lengths.map(|source| (source.below, source.text.lines().count()));
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

/// A module with files below it is a folder with a mod.rs.
#[test]
fn no_file_stands_beside_a_folder_of_its_name() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = ["src", "tests"].iter().flat_map(|folder| below(&root.join(folder)));
    let beside: Vec<_> = files.filter(|path| path.with_extension("").is_dir()).collect();
    assert!(beside.is_empty(), "{beside:?}");
}

/// Lines of the Rust files of these folders that are wider than the page.
fn too_wide(folders: &[&str]) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut wide = Vec::new();
    for path in folders.iter().flat_map(|folder| below(&root.join(folder))) {
        let text = fs::read_to_string(&path).unwrap();
        let lines = text.lines().zip(1..).filter(|(line, _)| line.chars().count() > WIDEST);
        let path = path.strip_prefix(root).unwrap().display();
        wide.extend(lines.map(|(_, number)| format!("{path}:{number}")));
    }
    wide
}

#[test]
fn no_line_is_wider_than_the_page() {
    let mut wide = too_wide(&["src", "tests", "benches", "examples"]);
    wide.retain(|line| !line.starts_with("src/python/"));
    assert_eq!(wide, [""; 0]);
}

#[test]
fn no_more_lines_of_the_binding_are_wider_than_the_page() {
    let wide = too_wide(&["src/python"]);
    assert!(wide.len() <= MOST_LONG_LINES_OF_THE_BINDING, "{wide:#?}");
}

/// Only the python room may know of Python, and it is gated once.
#[test]
fn only_one_room_knows_python() {
    let of_python = |text: &str| text.contains("pyo3") || text.contains("numpy");
    for Source { below, room, text } in sources() {
        assert!(room == "python" || !of_python(&text), "{}", below.display());
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs");
    let gates = fs::read_to_string(root).unwrap().matches("feature = \"python\"").count();
    assert!(gates <= 1, "{gates} gates");
}
