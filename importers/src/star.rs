//! The syntax of CIF files (STAR): names, values, loops (<https://www.iucr.org/resources/cif/spec/version1.1/cifsyntax>).

use crate::error::{Fault, Place};
use crate::text::Text;
use std::ops::Range;

/// A token of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Token {
    /// `data_...`
    Block,
    /// `loop_`
    Loop,
    /// `save_...`, `stop_`, `global_`: nothing of atoms.
    Other,
    /// A name that begins with `_`; in lower case.
    Name(String),
    /// A value, which [`Tokens::value`] has. `.` and `?` are values too, unless they are quoted.
    Value,
}

/// The tokens of a text.
pub(crate) struct Tokens<'t, 'a> {
    text: &'t mut Text<'a>,
    /// The current line, its number, and what is left of it.
    line: Vec<u8>,
    number: u64,
    at: usize,
    value: Range<usize>,
    is_quoted: bool,
    /// A value of several lines.
    field: Vec<u8>,
    is_field: bool,
    peeked: Option<Token>,
}

impl<'t, 'a> Tokens<'t, 'a> {
    pub(crate) fn new(text: &'t mut Text<'a>) -> Self {
        Self {
            text,
            line: Vec::new(),
            number: 0,
            at: 0,
            value: 0..0,
            is_quoted: false,
            field: Vec::new(),
            is_field: false,
            peeked: None,
        }
    }

    /// The last value.
    pub(crate) fn value(&self) -> &[u8] {
        if self.is_field { &self.field } else { &self.line[self.value.clone()] }
    }

    /// Whether the last value stands for none: `.` or `?`.
    pub(crate) fn is_null(&self) -> bool {
        !self.is_quoted && !self.is_field && matches!(self.value(), b"." | b"?")
    }

    /// The place of the last token.
    pub(crate) fn place(&self) -> Place {
        if self.is_field {
            Place::Line(self.number)
        } else {
            Place::Column(self.number, self.value.start as u64 + 1)
        }
    }

    pub(crate) fn fault(&self, problem: impl Into<String>) -> Fault {
        Fault { place: self.place(), problem: problem.into() }
    }

    /// The next token, which stays the next one. Only until then is [`Self::value`] the one before.
    pub(crate) fn peek(&mut self) -> Result<Option<&Token>, Fault> {
        if self.peeked.is_none() {
            self.peeked = self.read()?;
        }
        Ok(self.peeked.as_ref())
    }

    pub(crate) fn next_token(&mut self) -> Result<Option<Token>, Fault> {
        match self.peeked.take() {
            Some(token) => Ok(Some(token)),
            None => self.read(),
        }
    }

    fn read(&mut self) -> Result<Option<Token>, Fault> {
        self.is_field = false;
        loop {
            self.at += self.line[self.at..].iter().take_while(|byte| **byte <= b' ').count();
            if self.at < self.line.len() && self.line[self.at] != b'#' {
                return self.in_line().map(Some);
            }
            self.number = self.text.line();
            let Some(line) = self.text.next_line()? else { return Ok(None) };
            self.line.clear();
            self.line.extend_from_slice(line);
            self.at = 0;
            if self.line.first() == Some(&b';') {
                return self.several_lines().map(Some);
            }
        }
    }

    /// A token that begins at `at`.
    fn in_line(&mut self) -> Result<Token, Fault> {
        let rest = &self.line[self.at..];
        self.is_quoted = matches!(rest[0], b'"' | b'\'');
        if self.is_quoted {
            // A quotation mark ends the value only before white space.
            let ends = |(at, byte): (usize, &u8)| {
                *byte == rest[0] && rest.get(at + 1).is_none_or(|next| *next <= b' ')
            };
            let close = rest.iter().enumerate().skip(1).position(ends).map(|at| at + 1);
            let start = self.at + 1;
            self.value = start..start;
            let close =
                close.ok_or_else(|| self.fault("a quotation mark that closes the value is missing"))?;
            self.value = start..self.at + close;
            self.at += close + 1;
            return Ok(Token::Value);
        }
        let length = rest.iter().position(|byte| *byte <= b' ').unwrap_or(rest.len());
        self.value = self.at..self.at + length;
        self.at += length;
        Ok(word(&self.line[self.value.clone()]))
    }

    /// A value from a line that begins with `;` to the next such line.
    fn several_lines(&mut self) -> Result<Token, Fault> {
        /// No label is longer; what is beyond is not kept.
        const MOST: usize = 1 << 12;
        let begin = self.number;
        self.is_field = true;
        self.field.clear();
        self.field.extend_from_slice(&self.line[1..self.line.len().min(MOST)]);
        loop {
            self.number = self.text.line();
            let Some(line) = self.text.next_line()? else {
                return Err(Fault::line(
                    begin,
                    "the text that begins here with ; has no end: a line that begins with ;",
                ));
            };
            if line.first() == Some(&b';') {
                self.line.clear();
                self.line.extend_from_slice(&line[1..]);
                self.at = 0;
                return Ok(Token::Value);
            }
            if self.field.len() + line.len() < MOST {
                self.field.push(b'\n');
                self.field.extend_from_slice(line);
            }
        }
    }
}

/// What a word without quotation marks is.
fn word(word: &[u8]) -> Token {
    let begins =
        |with: &str| word.get(..with.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(with.as_bytes()));
    match word[0] {
        b'_' => Token::Name(String::from_utf8_lossy(word).to_ascii_lowercase()),
        b'd' | b'D' if begins("data_") => Token::Block,
        b'l' | b'L' if word.eq_ignore_ascii_case(b"loop_") => Token::Loop,
        b's' | b'S' if begins("save_") || begins("stop_") => Token::Other,
        b'g' | b'G' if begins("global_") => Token::Other,
        _ => Token::Value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::Position;
    use std::io::Cursor;

    fn tokens(text: &str) -> Result<Vec<String>, String> {
        let mut source = Cursor::new(text);
        let mut text = Text::new(&mut source, Position::START).unwrap();
        let (mut tokens, mut all) = (Tokens::new(&mut text), Vec::new());
        while let Some(token) =
            tokens.next_token().map_err(|fault| format!("{}: {}", fault.place, fault.problem))?
        {
            all.push(match token {
                Token::Value if tokens.is_null() => "null".into(),
                Token::Value => String::from_utf8_lossy(tokens.value()).into_owned(),
                token => format!("{token:?}"),
            });
        }
        Ok(all)
    }

    #[test]
    fn values_are_bare_quoted_or_of_several_lines() {
        let all =
            tokens("data_1 # comment\n_A 'it''s' # c\n\"a b\" . '.' O5'\n;one\n two\n; x\nloop_\n").unwrap();
        assert_eq!(
            all,
            ["Block", "Name(\"_a\")", "it''s", "a b", "null", ".", "O5'", "one\n two", "x", "Loop"]
        );
        // Words of the format are in any case, and so are names.
        assert_eq!(
            tokens("DATA_x LOOP_ _B.c Loop_ Data_").unwrap(),
            ["Block", "Loop", "Name(\"_b.c\")", "Loop", "Block"]
        );
        assert_eq!(
            tokens("SAVE_ Stop_ GLOBAL_ loops data").unwrap(),
            ["Other", "Other", "Other", "loops", "data"]
        );
        assert_eq!(tokens("'a'b' c").unwrap(), ["a'b", "c"]);
        assert_eq!(tokens("''").unwrap(), [""]);
    }

    #[test]
    fn what_has_no_end_is_told_with_its_line() {
        assert!(tokens("a\n 'b c").unwrap_err().starts_with(":2:3: a quotation mark"));
        assert!(tokens("a\n;b\nc").unwrap_err().starts_with(":2: the text that begins here"));
    }
}
