//! Splits the text of a selection into tokens.

use super::error::SelectionError;

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    /// A number, and as it was written.
    Number(f64, String),
    Text(String),
    /// A column or a word such as `and`.
    Name(String),
    /// An operator or a bracket.
    Sign(&'static str),
    End,
}

/// A token, the byte where it begins, and as it was written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) token: Token,
    pub(super) at: usize,
    pub(super) written: String,
}

/// Signs; of two that begin alike the longer one comes first.
const SIGNS: [&str; 9] = ["==", "!=", "<=", ">=", "<", ">", "(", ")", ","];

/// The tokens of `text`, the last of them [`Token::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<Place>, SelectionError> {
    let mut places = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        }
        let (token, length) = token(text, at, first)?;
        places.push(Place { token, at, written: text[at..at + length].into() });
        at += length;
    }
    places.push(Place { token: Token::End, at, written: String::new() });
    Ok(places)
}

/// The token at byte `at`, which begins with `first`, and its length in bytes.
fn token(text: &str, at: usize, first: char) -> Result<(Token, usize), SelectionError> {
    let rest = &text[at..];
    if let Some(sign) = SIGNS.into_iter().find(|sign| rest.starts_with(sign)) {
        return Ok((Token::Sign(sign), sign.len()));
    }
    if first == '"' || first == '\'' {
        let Some(end) = rest[1..].find(first) else {
            let problem = format!("this text has no end; close it with {first}");
            return Err(SelectionError::new(text, at, problem));
        };
        return Ok((Token::Text(rest[1..=end].into()), end + 2));
    }
    if first.is_ascii_alphabetic() || first == '_' {
        let length = rest.find(|c: char| !is_of_name(c)).unwrap_or(rest.len());
        return Ok((Token::Name(rest[..length].into()), length));
    }
    if first.is_ascii_digit() || "+-.".contains(first) {
        return number(text, at);
    }
    let right = match first {
        '=' => return Err(SelectionError::new(text, at, "`=` is no comparison; write `==`")),
        '&' | '|' => "; join conditions by `and` or `or`",
        '!' => "; write `not` before a condition",
        _ => "",
    };
    Err(SelectionError::new(text, at, format!("`{first}` does not belong in a selection{right}")))
}

/// Columns of simulations have names such as `c_pe[1]` and `v.x`.
fn is_of_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || "_.[]".contains(c)
}

fn number(text: &str, at: usize) -> Result<(Token, usize), SelectionError> {
    let rest = &text[at..];
    let mut before = ' ';
    let ends = |c: char| {
        let is_sign_of_exponent = (c == '+' || c == '-') && (before == 'e' || before == 'E' || before == ' ');
        let ends = !(c.is_ascii_alphanumeric() || c == '.' || is_sign_of_exponent);
        before = c;
        ends
    };
    let written = &rest[..rest.find(ends).unwrap_or(rest.len())];
    match written.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((Token::Number(value, written.into()), written.len())),
        _ => Err(SelectionError::new(text, at, format!("`{written}` is no number"))),
    }
}
