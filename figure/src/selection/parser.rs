//! Parses the tokens of a selection into a tree, by recursive descent.

use super::error::SelectionError;
use super::lexer::{Place, Token, tokens};

/// Deeper trees are refused, so that no text exhausts the stack.
const MOST_NESTED: usize = 100;

/// A condition.
#[derive(Clone, Debug)]
pub(super) enum Node {
    Or(Vec<Node>),
    And(Vec<Node>),
    Not(Box<Node>),
    Compare(Value, Comparison, Value),
    /// Whether a value is one of a list, or with `false` none of it.
    In(Value, Vec<Value>, bool),
}

impl Node {
    /// Appends the names of the columns in it to `names`.
    pub(super) fn columns<'a>(&'a self, names: &mut Vec<&'a str>) {
        let mut add = |value: &'a Value| {
            if let Kind::Column(name) = &value.kind {
                names.push(name);
            }
        };
        match self {
            Self::Or(nodes) | Self::And(nodes) => nodes.iter().for_each(|node| node.columns(names)),
            Self::Not(node) => node.columns(names),
            Self::Compare(left, _, right) => [left, right].into_iter().for_each(add),
            Self::In(value, _, _) => add(value),
        }
    }
}

/// A comparison of two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Comparison {
    Equal,
    Unequal,
    Below,
    AtMost,
    Above,
    AtLeast,
}

impl Comparison {
    fn of(sign: &str) -> Option<Self> {
        Some(match sign {
            "==" => Self::Equal,
            "!=" => Self::Unequal,
            "<" => Self::Below,
            "<=" => Self::AtMost,
            ">" => Self::Above,
            ">=" => Self::AtLeast,
            _ => return None,
        })
    }

    /// The comparison with its sides exchanged.
    pub(super) fn turned(self) -> Self {
        match self {
            Self::Below => Self::Above,
            Self::AtMost => Self::AtLeast,
            Self::Above => Self::Below,
            Self::AtLeast => Self::AtMost,
            same => same,
        }
    }
}

/// A value, and the byte where it stands.
#[derive(Clone, Debug)]
pub(super) struct Value {
    pub(super) kind: Kind,
    pub(super) at: usize,
}

#[derive(Clone, Debug)]
pub(super) enum Kind {
    /// A number, and as it was written.
    Number(f64, String),
    Text(String),
    Column(String),
}

/// Parses `text`.
pub(super) fn parse(text: &str) -> Result<Node, SelectionError> {
    let mut parser = Parser { text, places: tokens(text)?, next: 0, depth: 0 };
    let root = parser.any()?;
    match &parser.here().token {
        Token::End => Ok(root),
        Token::Sign(")") => Err(parser.misfit("")),
        _ => Err(parser.misfit("join conditions by `and` or `or`")),
    }
}

struct Parser<'a> {
    text: &'a str,
    places: Vec<Place>,
    next: usize,
    depth: usize,
}

impl Parser<'_> {
    fn here(&self) -> &Place {
        // The last token is `End`, which is never passed.
        &self.places[self.next.min(self.places.len() - 1)]
    }

    fn error(&self, at: usize, problem: impl Into<String>) -> SelectionError {
        SelectionError::new(self.text, at, problem)
    }

    /// The error that the next token does not fit; `right` says what would.
    fn misfit(&self, right: &str) -> SelectionError {
        let Place { at, written, .. } = self.here();
        let right = if right.is_empty() { String::new() } else { format!("; {right}") };
        self.error(*at, format!("`{written}` does not fit here{right}"))
    }

    fn takes_word(&mut self, word: &str) -> bool {
        let is_there = matches!(&self.here().token, Token::Name(name) if name == word);
        self.next += usize::from(is_there);
        is_there
    }

    fn takes_sign(&mut self, sign: &'static str) -> bool {
        let is_there = self.here().token == Token::Sign(sign);
        self.next += usize::from(is_there);
        is_there
    }

    fn needs_sign(&mut self, sign: &'static str, right: &str) -> Result<(), SelectionError> {
        match (self.takes_sign(sign), &self.here().token) {
            (true, _) => Ok(()),
            (false, Token::End) => {
                Err(self.error(self.here().at, format!("this ends where `{sign}` is needed")))
            }
            (false, _) => Err(self.misfit(right)),
        }
    }

    /// Runs `read` one level deeper.
    fn deeper(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<Node, SelectionError>,
    ) -> Result<Node, SelectionError> {
        if self.depth == MOST_NESTED {
            let problem = format!("conditions are nested deeper than {MOST_NESTED}");
            return Err(self.error(self.here().at, problem));
        }
        self.depth += 1;
        let node = read(self);
        self.depth -= 1;
        node
    }

    fn any(&mut self) -> Result<Node, SelectionError> {
        let mut nodes = vec![self.all()?];
        while self.takes_word("or") {
            nodes.push(self.all()?);
        }
        Ok(single(nodes, Node::Or))
    }

    fn all(&mut self) -> Result<Node, SelectionError> {
        let mut nodes = vec![self.one()?];
        while self.takes_word("and") {
            nodes.push(self.one()?);
        }
        Ok(single(nodes, Node::And))
    }

    fn one(&mut self) -> Result<Node, SelectionError> {
        if self.takes_word("not") {
            return self.deeper(|parser| Ok(Node::Not(Box::new(parser.one()?))));
        }
        if self.takes_sign("(") {
            let node = self.deeper(Self::any)?;
            self.needs_sign(")", "close the bracket with `)`")?;
            return Ok(node);
        }
        self.test()
    }

    fn test(&mut self) -> Result<Node, SelectionError> {
        let value = self.value()?;
        let is_not = self.takes_word("not");
        if self.takes_word("in") {
            return Ok(Node::In(value, self.list()?, !is_not));
        }
        let comparison = match self.here().token {
            Token::Sign(sign) => Comparison::of(sign),
            _ => None,
        };
        let Some(comparison) = comparison.filter(|_| !is_not) else {
            let problem = "a comparison is missing, such as `== \"O\"`, `> 3` or `in (1, 2)`";
            return Err(self.error(self.here().at, problem));
        };
        self.next += 1;
        let other = self.value()?;
        if let Token::Sign(sign) = self.here().token
            && Comparison::of(sign).is_some()
        {
            let problem = "one comparison at a time; write `0 < z and z < 3`";
            return Err(self.error(self.here().at, problem));
        }
        Ok(Node::Compare(value, comparison, other))
    }

    fn list(&mut self) -> Result<Vec<Value>, SelectionError> {
        self.needs_sign("(", "write a list, as in `type in (1, 2)`")?;
        let mut values = Vec::new();
        loop {
            let value = self.value()?;
            if let Kind::Column(_) = value.kind {
                return Err(
                    self.error(value.at, "a list holds numbers and texts alone; put a text in quotes")
                );
            }
            values.push(value);
            if !self.takes_sign(",") {
                break;
            }
        }
        self.needs_sign(")", "close the list with `)`")?;
        Ok(values)
    }

    fn value(&mut self) -> Result<Value, SelectionError> {
        const NEEDED: &str = "a column, a number or a text is needed";
        let Place { token, at, .. } = self.here().clone();
        let kind = match token {
            Token::Number(value, written) => Kind::Number(value, written),
            Token::Text(text) => Kind::Text(text),
            Token::Name(name) if !["and", "or", "not", "in"].contains(&name.as_str()) => Kind::Column(name),
            Token::End => {
                return Err(self.error(at, format!("this ends where {NEEDED}")));
            }
            _ => return Err(self.misfit(NEEDED)),
        };
        self.next += 1;
        Ok(Value { kind, at })
    }
}

/// The only one of `nodes`, or all of them as one.
fn single(mut nodes: Vec<Node>, join: fn(Vec<Node>) -> Node) -> Node {
    match nodes.pop() {
        Some(node) if nodes.is_empty() => node,
        Some(last) => {
            nodes.push(last);
            join(nodes)
        }
        None => join(nodes),
    }
}
