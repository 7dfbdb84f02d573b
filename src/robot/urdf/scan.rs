//! A look at the raw text before the XML reader sees it, in one pass and without recursion: what would cost it a stack, or
//! time beyond the file's size, is refused here.

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

/// Refuses what is too large, too deep, or has a DTD.
pub(super) fn check(text: &str) -> Result<(), ReadError> {
    files::limited(text)?;
    if !text.contains('<') {
        let message = format!(
            "got {} without a single element, wants the text of a URDF; give the name of a file to the function for files",
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
    let (mut depth, mut at) = (0_usize, 0);
    while let Some(open) = find(text, at, "<") {
        let rest = &text[open..];
        let end = if rest.starts_with("<!--") {
            find(text, open + 4, "-->").map(|end| end + 3)
        } else if rest.starts_with("<![CDATA[") {
            find(text, open, "]]>").map(|end| end + 3)
        } else if rest.starts_with("<?") {
            find(text, open, "?>").map(|end| end + 2)
        } else if rest.starts_with("<!") {
            let message = "got a document type definition, wants a URDF without one; delete it";
            return Err(ReadError::at(text, open, message));
        } else if rest.starts_with("</") {
            depth = depth.saturating_sub(1);
            Some(open + 2)
        } else {
            let tag = tag(rest);
            if tag.attributes > MOST_ATTRIBUTES {
                let message = format!(
                    "got more than {MOST_ATTRIBUTES} attributes in an element, wants fewer"
                );
                return Err(ReadError::at(text, open, message));
            }
            depth += usize::from(!tag.closed);
            Some(open + tag.length)
        };
        if depth > DEEPEST {
            let message =
                format!("got elements nested deeper than {DEEPEST}, wants a flatter file");
            return Err(ReadError::at(text, open, message));
        }
        match end {
            Some(end) => at = end,
            None => break,
        }
    }
    Ok(())
}

fn find(text: &str, from: usize, what: &str) -> Option<usize> {
    text.get(from..)?.find(what).map(|at| from + at)
}

struct Tag {
    /// Bytes from `<` up to where the next tag may begin.
    length: usize,
    closed: bool,
    attributes: usize,
}

/// The tag at the start of `rest`. An unfinished one ends where the next begins: the XML reader will complain.
fn tag(rest: &str) -> Tag {
    let (mut quote, mut before, mut attributes) = (None, b'<', 0);
    for (at, &byte) in rest.as_bytes().iter().enumerate().skip(1) {
        match (quote, byte) {
            (Some(open), _) if byte == open => quote = None,
            (_, b'<') => return Tag { length: at, closed: false, attributes },
            (Some(_), _) => {}
            (None, b'"' | b'\'') => {
                attributes += 1;
                quote = Some(byte);
            }
            (None, b'>') => return Tag { length: at + 1, closed: before == b'/', attributes },
            (None, _) => {}
        }
        before = byte;
    }
    Tag { length: rest.len(), closed: false, attributes }
}
