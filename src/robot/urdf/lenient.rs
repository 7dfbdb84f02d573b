//! XML as the common readers of URDF take it: they know no namespaces, and skip what they do not
//! use.
//!
//! Written over with spaces are comments, which may then hold dashes; declarations, wherever they
//! stand; the mark of the byte order; and attributes with a prefix. Colons in the names of elements
//! become `_`, so that no prefix need be declared. Every byte keeps its place and every line its
//! number. What is not well-formed stays, for the XML reader to refuse.

use super::scan::{Kind, Piece, Pieces};

/// The text for the XML reader, byte by byte as long as the file's.
pub(super) fn lenient(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let body = text.trim_start_matches('\u{feff}');
    blank(&mut out, &text[..text.len() - body.len()]);
    for Piece { kind, range } in Pieces::of(text) {
        // What stands between the pieces.
        out.push_str(text.get(out.len()..range.start).unwrap_or_default());
        let piece = &text[range];
        match kind {
            Kind::Unfinished => break,
            Kind::Comment | Kind::Instruction => blank(&mut out, piece),
            Kind::Opening { .. } => opening(&mut out, piece),
            Kind::Closing => out.push_str(&piece.replace(':', "_")),
            Kind::CharacterData | Kind::DocumentType => out.push_str(piece),
        }
    }
    out.push_str(text.get(out.len()..).unwrap_or_default());
    out
}

/// As many spaces; lines stay.
fn blank(out: &mut String, piece: &str) {
    let space = |byte| if matches!(byte, b'\n' | b'\r') { char::from(byte) } else { ' ' };
    out.extend(piece.bytes().map(space));
}

/// `<name attribute="value" …>`.
fn opening(out: &mut String, tag: &str) {
    let name = tag.find(|c: char| c.is_whitespace() || matches!(c, '/' | '>')).unwrap_or(tag.len());
    out.push_str(&tag[..name].replace(':', "_"));
    let mut rest = &tag[name..];
    while let Some(length) = attribute(rest) {
        let (piece, after) = rest.split_at(length);
        let name = piece.split('=').next().unwrap_or_default().trim();
        let one = !name.contains(|c: char| c.is_whitespace() || c == '/');
        match one && (name == "xmlns" || name.contains(':')) {
            true => blank(out, piece),
            false => out.push_str(piece),
        }
        rest = after;
    }
    out.push_str(rest);
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
