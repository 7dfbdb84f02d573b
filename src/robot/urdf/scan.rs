//! A look at the raw text before the XML reader sees it, in one pass and without recursion: what
//! would cost it a stack, or time beyond the file's size, is refused here.

use core::ops::Range;

use crate::robot::error::quoted;
use crate::robot::{ReadError, files};

/// Deepest nesting; URDF has five levels, the additions of simulators a dozen.
const DEEPEST: usize = 64;
/// Most attributes of an element; URDF has six.
const MOST_ATTRIBUTES: usize = 64;
/// Most namespaces that a file declares, and most sections of character data.
const MOST_RARITIES: usize = 64;
/// Most elements and texts.
pub(super) const MOST_NODES: u32 = 250_000;

/// What begins with `<`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Comment,
    CharacterData,
    Instruction,
    DocumentType,
    /// `</name>`.
    Closing,
    /// A tag that opens an element, up to its `>`.
    Opening {
        attributes: usize,
        /// True for `<…/>`.
        empty: bool,
    },
    /// What begins but does not end; the XML reader will complain.
    Unfinished,
}

/// One of the pieces that a text consists of, beside what stands between them.
pub(super) struct Piece {
    pub kind: Kind,
    pub range: Range<usize>,
}

/// The pieces of a text, one after another.
pub(super) struct Pieces<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Pieces<'a> {
    pub fn of(text: &'a str) -> Self {
        Self { text, at: 0 }
    }
}

impl Iterator for Pieces<'_> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        let open = find(self.text, self.at, "<")?;
        let rest = &self.text[open..];
        let until = |skip: usize, what: &str| Some(find(rest, skip, what)? + what.len());
        let (kind, length) = if rest.starts_with("<!--") {
            (Kind::Comment, until(4, "-->"))
        } else if rest.starts_with("<![CDATA[") {
            (Kind::CharacterData, until(9, "]]>"))
        } else if rest.starts_with("<?") {
            (Kind::Instruction, until(2, "?>"))
        } else if rest.starts_with("<!") {
            (Kind::DocumentType, Some(2))
        } else if let Some(name) = rest.strip_prefix("</") {
            let end = name.find(['<', '>']).unwrap_or(name.len());
            (Kind::Closing, Some(2 + end + usize::from(name[end..].starts_with('>'))))
        } else {
            opening(rest)
        };
        let (kind, length) = match length {
            Some(length) => (kind, length),
            None => (Kind::Unfinished, rest.len()),
        };
        self.at = open + length;
        Some(Piece { kind, range: open..self.at })
    }
}

/// Refuses what is too large, too deep, or has a DTD.
pub(super) fn check(text: &str) -> Result<(), ReadError> {
    files::limited(text)?;
    if !text.contains('<') {
        let message = format!(
            "got {} without a single element, wants the text of a URDF; give the name of a file \
             to the function for files",
            quoted(text.trim())
        );
        return Err(ReadError::new(message));
    }
    for (rarity, what) in [("xmlns", "namespaces"), ("<![CDATA[", "sections of character data")] {
        if let Some((at, _)) = text.match_indices(rarity).nth(MOST_RARITIES) {
            let message = format!("got more than {MOST_RARITIES} {what}, wants fewer");
            return Err(ReadError::at(text, at, message));
        }
    }
    depth(text)
}

/// Walks from tag to tag.
fn depth(text: &str) -> Result<(), ReadError> {
    let mut depth = 0_usize;
    for Piece { kind, range } in Pieces::of(text) {
        let refused = |message: String| Err(ReadError::at(text, range.start, message));
        match kind {
            Kind::DocumentType => {
                let message = "got a document type definition, wants a URDF without one; delete it";
                return refused(message.to_owned());
            }
            Kind::Opening { attributes, .. } if attributes > MOST_ATTRIBUTES => {
                return refused(format!(
                    "got more than {MOST_ATTRIBUTES} attributes in an element, wants fewer"
                ));
            }
            Kind::Opening { empty, .. } => depth += usize::from(!empty),
            Kind::Closing => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST {
            return refused(format!(
                "got elements nested deeper than {DEEPEST}, wants a flatter file"
            ));
        }
    }
    Ok(())
}

fn find(text: &str, from: usize, what: &str) -> Option<usize> {
    text.get(from..)?.find(what).map(|at| from + at)
}

/// The tag at the start of `rest`, and its length. An unfinished one ends where the next begins.
fn opening(rest: &str) -> (Kind, Option<usize>) {
    let (mut quote, mut before, mut attributes) = (None, b'<', 0);
    for (at, &byte) in rest.as_bytes().iter().enumerate().skip(1) {
        match (quote, byte) {
            (Some(open), _) if byte == open => quote = None,
            (Some(_), _) => {}
            (None, b'<') => return (Kind::Unfinished, Some(at)),
            (None, b'"' | b'\'') => {
                attributes += 1;
                quote = Some(byte);
            }
            (None, b'>') => {
                return (Kind::Opening { attributes, empty: before == b'/' }, Some(at + 1));
            }
            (None, _) => {}
        }
        before = byte;
    }
    (Kind::Unfinished, None)
}
