//! The names that a file takes from elsewhere: what it imports, and the paths it writes out.

/// A path with what it means where it stands.
#[derive(Debug, PartialEq)]
pub struct Name<'a> {
    /// `crate::a::B` in its parts; `*` for all.
    pub path: Vec<&'a str>,
    /// Modules written out in the file around it: each takes one `super`.
    pub inside: usize,
    pub kind: Kind<'a>,
}

#[derive(Debug, PartialEq)]
pub enum Kind<'a> {
    /// `use`, by the name it has from then on.
    Import(&'a str),
    /// `pub use`, of any visibility.
    Export(&'a str),
    /// In an expression or a type.
    Written,
}

/// Words and signs of a text, without comments, literal texts and lifetimes; `::` is one sign.
pub fn tokens(text: &str) -> Vec<&str> {
    let (mut tokens, mut rest) = (Vec::new(), text);
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let length = if first.is_whitespace() {
            first.len_utf8()
        } else if let Some(length) = ignored(rest) {
            length
        } else {
            let word = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            let sign = if rest.starts_with("::") { 2 } else { first.len_utf8() };
            let length = if word > 0 { word } else { sign };
            tokens.push(&rest[..length]);
            length
        };
        rest = &rest[length..];
    }
    tokens
}

/// The length of the comment, literal text or lifetime that a text begins with.
fn ignored(text: &str) -> Option<usize> {
    let through = |from: usize, end: &str| text[from..].find(end).map(|at| from + at + end.len());
    let hashes = text.get(1..)?.find(|c| c != '#')?;
    if text.starts_with("//") {
        Some(text.find('\n').unwrap_or(text.len()))
    } else if text.starts_with("/*") {
        through(2, "*/")
    } else if text.starts_with('r') && text[1 + hashes..].starts_with('"') {
        through(2 + hashes, &format!("\"{}", "#".repeat(hashes)))
    } else if text.starts_with('"') {
        let mut escaped = false;
        let end = text[1..].find(|c| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        end.map(|at| at + 2)
    } else if let Some(after) = text.strip_prefix('\'') {
        let mut signs = after.char_indices().skip(1);
        match (after.chars().next()?, signs.next()?) {
            ('\\', (at, _)) => after[at + 1..].find('\'').map(|end| at + end + 3),
            (_, (at, '\'')) => Some(at + 2),
            _ => Some(1 + after.find(|c: char| !c.is_alphanumeric() && c != '_')?),
        }
    } else {
        None
    }
}

/// All names of a file.
pub fn names<'a>(tokens: &[&'a str]) -> Vec<Name<'a>> {
    let (mut names, mut depth, mut inside, mut at) = (Vec::new(), 0, Vec::new(), 0);
    while at < tokens.len() {
        match tokens[at] {
            "{" => depth += 1,
            "}" => {
                depth -= 1;
                inside.retain(|&outer| outer < depth);
            }
            "mod" if tokens.get(at + 2) == Some(&"{") => inside.push(depth),
            "use" if tokens.get(at + 1) != Some(&"<") => {
                let public = at > 0 && (tokens[at - 1] == "pub" || tokens[at - 1] == ")");
                let mut found = Vec::new();
                at = imported(tokens, at + 1, &[], &mut found);
                names.extend(found.into_iter().map(|(path, name)| {
                    let kind = if public { Kind::Export(name) } else { Kind::Import(name) };
                    Name { path, inside: inside.len(), kind }
                }));
            }
            _ if is_name(tokens[at]) && tokens.get(at + 1) == Some(&"::") => {
                let mut path = vec![tokens[at]];
                while tokens.get(at + 1) == Some(&"::") && is_name(tokens[at + 2]) {
                    path.push(tokens[at + 2]);
                    at += 2;
                }
                names.push(Name { path, inside: inside.len(), kind: Kind::Written });
            }
            _ => {}
        }
        at += 1;
    }
    names
}

pub fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Reads the tree of a `use` from a place on, with the path before it; returns the place of what
/// ends it.
fn imported<'a>(
    tokens: &[&'a str],
    mut at: usize,
    before: &[&'a str],
    found: &mut Vec<(Vec<&'a str>, &'a str)>,
) -> usize {
    let mut path = before.to_vec();
    loop {
        match tokens[at] {
            "::" => at += 1,
            "{" => {
                while tokens[at] != "}" {
                    at = imported(tokens, at + 1, &path, found);
                }
                return at + 1;
            }
            "," | "}" | ";" => {
                if let (true, Some(last)) = (path.len() > before.len(), path.last().copied()) {
                    found.push((path, last));
                }
                return at;
            }
            "as" => {
                found.push((path, tokens[at + 1]));
                return at + 2;
            }
            "self" if !path.is_empty() => {
                found.extend(path.last().copied().map(|last| (path.clone(), last)));
                path.truncate(before.len());
                at += 1;
            }
            part => {
                path.push(part);
                at += 1;
            }
        }
    }
}

#[test]
fn names_are_found_in_every_form() {
    let text = r##"
        pub(crate) use super::a::X;
        use crate::{b::{self, Y, Z as W}, c,
            d::*};
        // crate::f
        mod inner { use super::i; }
        fn g<'a>(x: &'a u8) {
            let y = crate::g::h::<u8>(b"crate::j"); 'c'; '\'';
            r#"crate::k"#; }"##;
    let tokens = tokens(text);
    let found: Vec<_> = names(&tokens)
        .into_iter()
        .map(|name| format!("{} {} {:?}", name.path.join("::"), name.inside, name.kind))
        .collect();
    let wanted = [
        "super::a::X 0 Export(\"X\")",
        "crate::b 0 Import(\"b\")",
        "crate::b::Y 0 Import(\"Y\")",
        "crate::b::Z 0 Import(\"W\")",
        "crate::c 0 Import(\"c\")",
        "crate::d::* 0 Import(\"*\")",
        "super::i 1 Import(\"i\")",
        "crate::g::h 0 Written",
    ];
    assert_eq!(found, wanted);
}
