//! Circles of names between files. A name that a file only passes on counts where it is defined.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::names::{Kind, is_name, names, tokens};
use super::{Source, files};

/// Circles that remain, as sets of files that need each other. Do not add: take apart.
const KNOWN: [&[&str]; 1] =
    [&["arm/implicit.rs", "arm/mod.rs", "arm/posed.rs", "arm/resistance.rs"]];

/// Names that a name is passed on under; more is a module that imports from itself.
const MOST_STEPS: usize = 32;

type Module = Vec<String>;
/// A path and the number of modules in the file around it.
type Target = (Vec<String>, usize);

#[derive(Default)]
struct File {
    defined: BTreeSet<String>,
    /// What a name of another file is called here.
    imported: BTreeMap<String, Target>,
    /// Paths that make this file need another.
    needs: Vec<Target>,
}

/// The module of a file below src: `arm/serial/mod.rs` and `arm/serial.rs` are arm, serial.
fn module(relative: &Path) -> Module {
    let parts = relative.with_extension("");
    let parts = parts.iter().map(|part| part.to_str().unwrap().to_owned());
    parts.filter(|part| part != "mod" && part != "lib").collect()
}

fn read(text: &str) -> File {
    let tokens = tokens(text);
    let mut file = File { defined: defined(&tokens), ..File::default() };
    for name in names(&tokens) {
        let path = name.path.iter().map(|&part| part.to_owned()).collect();
        let target: Target = (path, name.inside);
        match name.kind {
            Kind::Import(known) => {
                file.imported.insert(known.to_owned(), target.clone());
                file.needs.push(target);
            }
            Kind::Export(known) => {
                file.imported.insert(known.to_owned(), target.clone());
                if used(&tokens, known) {
                    file.needs.push(target);
                }
            }
            Kind::Written => file.needs.push(target),
        }
    }
    file
}

/// The names that a file defines, but for those within its blocks.
fn defined(tokens: &[&str]) -> BTreeSet<String> {
    let words = ["struct", "enum", "trait", "fn", "type", "const", "static", "union"];
    let (mut defined, mut depth) = (BTreeSet::new(), 0);
    for at in 0..tokens.len().saturating_sub(2) {
        match tokens[at..at + 3] {
            ["{", ..] => depth += 1,
            ["}", ..] => depth -= 1,
            ["macro_rules", "!", name] => drop(defined.insert(name.to_owned())),
            [word, name, _] if depth == 0 && words.contains(&word) && is_name(name) => {
                defined.insert(name.to_owned());
            }
            _ => {}
        }
    }
    defined
}

/// Whether a file needs a name itself, beyond the statements that pass it on and the module of that
/// name.
fn used(tokens: &[&str], name: &str) -> bool {
    let (mut importing, mut before) = (false, "");
    tokens.iter().any(|&token| {
        importing = token == "use" || importing && token != ";";
        let module = std::mem::replace(&mut before, token) == "mod";
        token == name && !importing && !module
    })
}

/// The module whose file defines what a path names as seen from a module; None for another crate,
/// or a module itself.
fn home(files: &BTreeMap<Module, File>, from: &Module, target: &Target) -> Option<Module> {
    let (mut here, (mut path, mut inside)) = (from.clone(), target.clone());
    for _ in 0..MOST_STEPS {
        let relative = !matches!(path.first()?.as_str(), "crate" | "super" | "self");
        while let Some(first @ ("crate" | "super" | "self")) = path.first().map(String::as_str) {
            match first {
                "crate" => here.clear(),
                "super" if inside > 0 => inside -= 1,
                "super" => drop(here.pop()),
                _ => {}
            }
            path.remove(0);
        }
        let name = path.first()?;
        let (file, child) = (&files[&here], [&here[..], core::slice::from_ref(name)].concat());
        if files.contains_key(&child) {
            path[0] = "self".to_owned();
            here = child;
            continue;
        }
        match file.imported.get(name) {
            Some(next) if !file.defined.contains(name) => {
                (path, inside) = ([&next.0, &path[1..]].concat(), next.1);
            }
            None if relative && !file.defined.contains(name) => return None,
            _ => return Some(here),
        }
    }
    None
}

/// For every file, the files that it needs.
fn needs(sources: &[Source]) -> BTreeMap<String, BTreeSet<String>> {
    let files: BTreeMap<_, _> =
        sources.iter().map(|source| (module(&source.below), read(&source.text))).collect();
    let paths: BTreeMap<_, _> = sources
        .iter()
        .map(|source| (module(&source.below), source.below.to_str().unwrap().to_owned()))
        .collect();
    let needed = files.iter().map(|(module, file)| {
        let homes = file.needs.iter().filter_map(|target| home(&files, module, target));
        let others = homes.filter(|home| home != module).map(|home| paths[&home].clone());
        (paths[module].clone(), others.collect())
    });
    needed.collect()
}

/// Sets of files each of which needs, directly or not, every other.
fn circles(needs: &BTreeMap<String, BTreeSet<String>>) -> BTreeSet<BTreeSet<String>> {
    let reached = |from: &String| {
        let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(file) = open.pop() {
            open.extend(needs[file].iter().filter(|&next| reached.insert(next.clone())));
        }
        reached
    };
    let reached: BTreeMap<_, _> = needs.keys().map(|file| (file, reached(file))).collect();
    let round = reached.iter().filter(|(file, far)| far.contains(**file));
    round
        .map(|(file, far)| {
            far.iter().filter(|other| reached[other].contains(*file)).cloned().collect()
        })
        .collect()
}

#[test]
fn files_do_not_need_each_other() {
    let needs = needs(&files());
    let known = KNOWN.map(|circle| circle.iter().map(|&file| file.to_owned()).collect());
    let known = BTreeSet::from(known);
    let found = circles(&needs);
    for circle in found.difference(&known) {
        for file in circle {
            println!("{file} needs {:?}", needs[file].intersection(circle).collect::<Vec<_>>());
        }
    }
    assert_eq!(found, known, "a new circle, or one that is listed and no more");
}

#[test]
fn a_circle_is_found_through_what_is_passed_on() {
    let source = |below: &str, text: &str| Source {
        below: below.into(),
        room: String::new(),
        text: text.to_owned(),
    };
    let texts = [
        ("lib.rs", "pub mod a; pub mod b; pub use a::Up;"),
        ("a/mod.rs", "mod up; mod down; pub use up::Up; pub use down::DOWN;"),
        ("a/up.rs", "use super::DOWN; pub struct Up; mod tests { use super::*; }"),
        ("a/down.rs", "pub const DOWN: usize = size_of::<crate::Up>(); fn f() { super::g(); }"),
        ("b.rs", "use crate::a::{self, Up}; const B: usize = a::DOWN;"),
    ];
    let needs = needs(&texts.map(|(below, text)| source(below, text)));
    let of = |file: &str| needs[file].iter().cloned().collect::<Vec<_>>();
    assert_eq!(of("lib.rs"), [""; 0]);
    assert_eq!(of("a/down.rs"), ["a/mod.rs", "a/up.rs"]);
    assert_eq!(of("b.rs"), ["a/down.rs", "a/up.rs"]);
    let circle = ["a/down.rs", "a/up.rs"].map(str::to_owned);
    assert_eq!(circles(&needs), BTreeSet::from([BTreeSet::from(circle)]));
}
