//! XML as the common readers of URDF take it: they know no namespaces, and skip what they do not
//! use.
//!
//! Written over with spaces are comments, which may then hold dashes; declarations, wherever they
//! stand; the mark of the byte order; attributes with a prefix; and the attributes of elements, and
//! the texts, that are not read. Colons in the names of elements become `_`, so that no prefix need
//! be declared. Every byte keeps its place and every line its number. What is not well-formed in
//! what is read stays, for the XML reader to refuse.

use super::scan::{Kind, Piece, Pieces};

/// Elements whose attributes are read.
const READ: [&str; 18] = [
    "robot",
    "link",
    "joint",
    "inertial",
    "origin",
    "mass",
    "inertia",
    "parent",
    "child",
    "axis",
    "limit",
    "dynamics",
    "mimic",
    "transmission",
    "geometry",
    "box",
    "cylinder",
    "sphere",
];
/// Elements whose value or text is read, with any prefix.
const NUMBERS: [&str; 4] = ["gear_ratio", "rotor_inertia", "mechanicalReduction", "motorInertia"];

/// The text for the XML reader, byte by byte as long as the file's.
pub(super) fn lenient(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let body = text.trim_start_matches('\u{feff}');
    blank(&mut out, &text[..text.len() - body.len()]);
    let (mut depth, mut in_number) = (0_usize, false);
    for Piece { kind, range } in Pieces::of(text) {
        let between = text.get(out.len()..range.start).unwrap_or_default();
        let text_is_read = in_number || depth == 0;
        copy(&mut out, between, text_is_read);
        let piece = &text[range];
        match kind {
            Kind::Unfinished => break,
            Kind::Comment | Kind::Instruction => blank(&mut out, piece),
            Kind::CharacterData => copy(&mut out, piece, text_is_read),
            Kind::DocumentType => out.push_str(piece),
            Kind::Opening { empty, .. } => {
                in_number = opening(&mut out, piece, empty) && !empty;
                depth += usize::from(!empty);
            }
            Kind::Closing => {
                out.push_str(&piece.replace(':', "_"));
                in_number = false;
                depth = depth.saturating_sub(1);
            }
        }
    }
    out.push_str(text.get(out.len()..).unwrap_or_default());
    out
}

fn copy(out: &mut String, piece: &str, is_read: bool) {
    match is_read {
        true => out.push_str(piece),
        false => blank(out, piece),
    }
}

/// As many spaces; lines stay.
fn blank(out: &mut String, piece: &str) {
    let space = |byte| if matches!(byte, b'\n' | b'\r') { char::from(byte) } else { ' ' };
    out.extend(piece.bytes().map(space));
}

/// `<name attribute="value" …>`; true if it is one of the [`NUMBERS`].
fn opening(out: &mut String, tag: &str, empty: bool) -> bool {
    let (start, end) = tag.split_at(tag.len() - if empty { 2 } else { 1 });
    let length = start.find(char::is_whitespace).unwrap_or(start.len());
    let (name, mut rest) = start.split_at(length);
    out.push_str(&name.replace(':', "_"));
    let name = name.trim_start_matches('<');
    let is_number = name.rsplit(':').next().is_some_and(|name| NUMBERS.contains(&name));
    if !is_number && !READ.contains(&name) {
        blank(out, rest);
        rest = "";
    }
    while let Some(length) = attribute(rest) {
        let (piece, after) = rest.split_at(length);
        let name = piece.split('=').next().unwrap_or_default().trim();
        let one = !name.contains(|c: char| c.is_whitespace() || c == '/');
        copy(out, piece, !(one && (name == "xmlns" || name.contains(':'))));
        rest = after;
    }
    out.push_str(rest);
    out.push_str(end);
    is_number
}

/// The length of ` name = "value"` at the start of `rest`, if it stands there.
fn attribute(rest: &str) -> Option<usize> {
    let equals = rest.find(['=', '"', '\'', '>']).filter(|&at| rest[at..].starts_with('='))?;
    let value = &rest[equals + 1..];
    let open = value.find(|c: char| !c.is_whitespace())?;
    let quote = value[open..].chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
    let close = value[open + 1..].find(quote)?;
    Some(equals + 1 + open + 1 + close + 1)
}
