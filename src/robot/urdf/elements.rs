//! Elements and attributes, read strictly: numbers are finite, threes are three, nothing stands twice.

use roxmltree::Node;

use crate::robot::ReadError;
use crate::robot::error::{line_of, quoted};

/// The file's text, which turns positions into lines.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub text: &'a str,
}

impl Source<'_> {
    /// An error about what stands at the byte `at`.
    pub fn error(&self, at: usize, message: impl Into<String>) -> ReadError {
        ReadError::at(self.text, at, message)
    }

    pub fn line(&self, at: usize) -> usize {
        line_of(self.text, at)
    }

    /// Refuses files that are still to be expanded.
    pub fn refuse_macros(&self, robot: Node) -> Result<(), ReadError> {
        let is_macro =
            |node: &Node| node.tag_name().namespace().is_some_and(|space| space.contains("xacro"));
        match robot.children().find(is_macro) {
            None => Ok(()),
            Some(node) => Err(self.error(
                node.range().start,
                "got xacro, wants URDF; run `xacro robot.xacro > robot.urdf` first",
            )),
        }
    }

    /// The child of that name, if there is one.
    pub fn child<'a, 'input>(
        &self,
        parent: Node<'a, 'input>,
        name: &str,
        owner: &str,
    ) -> Result<Option<Node<'a, 'input>>, ReadError> {
        let mut found = parent.children().filter(|node| node.has_tag_name(name));
        let first = found.next();
        match found.next() {
            None => Ok(first),
            Some(second) => Err(self
                .error(second.range().start, format!("{owner}: got a second <{name}>, wants one"))),
        }
    }

    /// An attribute that must be there and say something.
    pub fn text<'a>(
        &self,
        node: Node<'a, '_>,
        name: &str,
        owner: &str,
    ) -> Result<&'a str, ReadError> {
        let tag = node.tag_name().name();
        match node.attribute(name).map(str::trim) {
            Some(value) if !value.is_empty() => Ok(value),
            Some(_) => Err(self.error(
                node.range().start,
                format!("{owner}: got an empty {name} in <{tag}>, wants a name"),
            )),
            None => Err(self.error(
                node.range().start,
                format!("{owner}: got <{tag}> without {name}, wants <{tag} {name}=\"…\">"),
            )),
        }
    }

    /// The number of an attribute, which may be infinite where `infinite`.
    pub fn number(
        &self,
        node: Node,
        name: &str,
        owner: &str,
        infinite: bool,
    ) -> Result<Option<f64>, ReadError> {
        let Some(attribute) = node.attribute_node(name) else { return Ok(None) };
        let value = attribute.value().trim();
        match value.parse::<f64>() {
            Ok(number) if number.is_finite() || (infinite && !number.is_nan()) => Ok(Some(number)),
            _ => Err(self.error(
                attribute.range().start,
                format!(
                    "{owner}, <{} {name}>: got {}, wants a finite number",
                    node.tag_name().name(),
                    quoted(value)
                ),
            )),
        }
    }

    /// The number of an attribute that must be there.
    pub fn required(&self, node: Node, name: &str, owner: &str) -> Result<f64, ReadError> {
        self.number(node, name, owner, false)?.ok_or_else(|| {
            let tag = node.tag_name().name();
            let message = format!("{owner}: got <{tag}> without {name}, wants a finite number");
            self.error(node.range().start, message)
        })
    }

    /// The number of an attribute that must not be negative; 0 where it is absent.
    pub fn at_least_zero(&self, node: Node, name: &str, owner: &str) -> Result<f64, ReadError> {
        let value = self.number(node, name, owner, false)?.unwrap_or(0.0);
        if value >= 0.0 {
            return Ok(value);
        }
        let tag = node.tag_name().name();
        Err(self.error(
            attribute_at(node, name),
            format!("{owner}, <{tag} {name}>: got {value}, wants a number >= 0"),
        ))
    }

    /// The three numbers of an attribute, if it is there.
    pub fn three(
        &self,
        node: Node,
        name: &str,
        owner: &str,
    ) -> Result<Option<[f64; 3]>, ReadError> {
        let Some(attribute) = node.attribute_node(name) else { return Ok(None) };
        let mut three = [0.0; 3];
        let mut words = attribute.value().split_ascii_whitespace();
        let filled = three.iter_mut().all(|entry| match words.next().map(str::parse::<f64>) {
            Some(Ok(number)) if number.is_finite() => {
                *entry = number;
                true
            }
            _ => false,
        });
        if filled && words.next().is_none() {
            return Ok(Some(three));
        }
        Err(self.error(
            attribute.range().start,
            format!(
                "{owner}, <{} {name}>: got {}, wants three finite numbers with spaces between",
                node.tag_name().name(),
                quoted(attribute.value())
            ),
        ))
    }
}

/// Where an attribute stands, or else its element.
pub(super) fn attribute_at(node: Node, name: &str) -> usize {
    node.attribute_node(name).map_or(node.range().start, |attribute| attribute.range().start)
}
