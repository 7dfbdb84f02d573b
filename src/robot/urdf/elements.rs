//! Elements and attributes, read strictly: numbers are finite, threes are three, nothing stands
//! twice.

use roxmltree::Node;

use crate::arm::Pose;
use crate::robot::error::quoted;
use crate::robot::{ReadError, frames};

/// Lines are counted once for every so many bytes: a file with many faults takes no longer than it
/// is long.
const BLOCK: usize = 1024;

/// The file's text, which turns positions into lines and has the names as they are written.
pub(super) struct Document<'a> {
    text: &'a str,
    /// The line in which each block begins, and that of the end.
    lines: Vec<usize>,
}

/// Elements of xacro that only define: what they leave behind changes nothing.
const DEFINITIONS: [&str; 3] = ["property", "arg", "macro"];

const EXPAND: &str = "wants URDF; expand it first: `pip install xacrodoc`, then \
    `xacrodoc robot.urdf.xacro -o robot.urdf` (or ROS's `xacro robot.urdf.xacro -o robot.urdf`)";

impl<'a> Document<'a> {
    pub fn new(text: &'a str) -> Self {
        let mut lines = vec![1];
        for block in text.as_bytes().chunks(BLOCK) {
            lines.push(lines[lines.len() - 1] + ends_of_lines(block));
        }
        Self { text, lines }
    }

    /// An error about what stands at the byte `at`.
    pub fn error(&self, at: usize, message: impl Into<String>) -> ReadError {
        ReadError::new(message).on_line(self.line(at))
    }

    /// The line, counted from 1, that holds the byte `at`.
    pub fn line(&self, at: usize) -> usize {
        let block = (at / BLOCK).min(self.lines.len() - 1);
        let rest = self.text.as_bytes().get(block * BLOCK..at).unwrap_or_default();
        self.lines[block] + ends_of_lines(rest)
    }

    /// The name of an element as it is written, with its prefix.
    pub fn name(&self, node: Node) -> &'a str {
        let tag = self.text.get(node.range()).unwrap_or_default().trim_start_matches('<');
        let end = tag.find(|c: char| c.is_whitespace() || matches!(c, '/' | '>'));
        tag.get(..end.unwrap_or(tag.len())).unwrap_or_default()
    }

    /// Its name without the prefix.
    pub fn local_name(&self, node: Node) -> &'a str {
        self.name(node).rsplit(':').next().unwrap_or_default()
    }

    /// Refuses what xacro would still put in the place of a child of this element.
    pub fn refuse_macros(&self, parent: Node) -> Result<(), ReadError> {
        match self.macro_in(parent, |name| !DEFINITIONS.contains(&name)) {
            None => Ok(()),
            Some(node) => Err(self.unexpanded(node)),
        }
    }

    /// The first child that is xacro's, of those with such a name.
    pub fn macro_in<'n, 'i>(
        &self,
        parent: Node<'n, 'i>,
        such: impl Fn(&str) -> bool,
    ) -> Option<Node<'n, 'i>> {
        let elements = parent.children().filter(Node::is_element);
        let mut of_xacro = elements.filter(|&node| {
            self.name(node)
                .split_once(':')
                .is_some_and(|(prefix, name)| prefix == "xacro" && such(name))
        });
        of_xacro.next()
    }

    pub fn unexpanded(&self, node: Node) -> ReadError {
        let name = quoted(self.name(node));
        let message = format!("got <{}> of a xacro, {EXPAND}", name.trim_matches('"'));
        self.error(node.range().start, message)
    }

    /// An error about the value at the byte `at`, which may be one that xacro would still replace.
    fn wrong_value(&self, at: usize, value: &str, message: String) -> ReadError {
        match is_expression(value) {
            true => self.error(at, format!("{message}: the file is a xacro, {EXPAND}")),
            false => self.error(at, message),
        }
    }

    /// The child of that name, if there is one.
    pub fn child<'n, 'i>(
        &self,
        parent: Node<'n, 'i>,
        name: &str,
        owner: &str,
    ) -> Result<Option<Node<'n, 'i>>, ReadError> {
        let mut found = parent.children().filter(|node| node.has_tag_name(name));
        let first = found.next();
        match found.next() {
            None => Ok(first),
            Some(second) => Err(self
                .error(second.range().start, format!("{owner}: got a second <{name}>, wants one"))),
        }
    }

    /// An attribute that must be there and say something.
    pub fn text<'n>(
        &self,
        node: Node<'n, '_>,
        name: &str,
        owner: &str,
    ) -> Result<&'n str, ReadError> {
        let tag = node.tag_name().name();
        match node.attribute(name).map(str::trim) {
            Some(value) if is_expression(value) => Err(self.wrong_value(
                attribute_at(node, name),
                value,
                format!("{owner}, <{tag} {name}>: got {}", quoted(value)),
            )),
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
            _ => Err(self.wrong_value(
                attribute.range().start,
                value,
                format!(
                    "{owner}, <{} {name}>: got {}, wants a finite number",
                    self.name(node),
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

    /// `<origin>` of an element, or no displacement.
    pub fn origin(&self, parent: Node, owner: &str) -> Result<Pose, ReadError> {
        let Some(node) = self.child(parent, "origin", owner)? else { return Ok(Pose::IDENTITY) };
        let xyz = self.three(node, "xyz", owner)?.unwrap_or_default();
        let rpy = self.three(node, "rpy", owner)?.unwrap_or_default();
        Ok(Pose { rotation: frames::roll_pitch_yaw(rpy), translation: xyz.into() })
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
        Err(self.wrong_value(
            attribute.range().start,
            attribute.value(),
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

/// True for what xacro would replace: `${…}` and `$(…)`.
fn is_expression(value: &str) -> bool {
    value.contains("${") || value.contains("$(")
}

fn ends_of_lines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}
