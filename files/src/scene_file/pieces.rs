//! Splits the text of a scene file into tables, which are parsed one at a time.
//!
//! A parsed table takes some 40 times as much memory as its text, and a scene may have millions of spheres. So each
//! `[[sphere]]` and each `[materials.NAME]` is a piece that is parsed by itself; all other tables together are the
//! head of the scene.

use super::error::Fault;
use super::syntax_fault;
use std::iter::Peekable;
use std::ops::Range;
use toml::de::DeTable;
use toml_parser::Source;
use toml_parser::lexer::{Lexer, TokenKind};

/// Most bytes of the head, and of any other piece.
pub(super) const MOST_BYTES: usize = 1 << 22;

/// What a piece of text defines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The next sphere: `[[sphere]]`, and tables within it that follow directly.
    Sphere,
    /// A material: `[materials.NAME]`.
    Material,
    /// Anything else.
    Head,
}

/// A piece of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    pub(super) kind: Kind,
    pub(super) span: Range<usize>,
}

/// The pieces of a text, in order. They cover all of it.
pub(super) struct Pieces<'a> {
    text: &'a str,
    tokens: Peekable<Lexer<'a>>,
    /// The kind and the beginning of the next piece; `None` at the end of the text.
    next: Option<(Kind, usize)>,
}

/// A header of a table, as far as pieces depend on it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Header {
    Begins(Kind),
    /// `[sphere.KEY]`, a table within a sphere.
    WithinSphere,
}

impl<'a> Pieces<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, tokens: Source::new(text).lex().peekable(), next: Some((Kind::Head, 0)) }
    }

    /// Reads tokens up to the next header, and returns it with its beginning.
    ///
    /// A header begins a line outside of arrays and inline tables. `[[sphere]]` cannot stand within those either, so
    /// it counts anywhere at the beginning of a line: a bracket that is never closed spoils one sphere alone.
    fn next_header(&mut self) -> Option<(Header, usize)> {
        let (mut depth, mut is_line_start) = (0_usize, true);
        while let Some(token) = self.tokens.next() {
            match token.kind() {
                TokenKind::Whitespace => continue,
                TokenKind::Newline => {
                    is_line_start = true;
                    continue;
                }
                TokenKind::Eof => return None,
                TokenKind::LeftSquareBracket if is_line_start => {
                    let (header, opened) = self.header();
                    if depth == 0 || header == Header::Begins(Kind::Sphere) {
                        return Some((header, token.span().start()));
                    }
                    depth += opened;
                }
                TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket => depth += 1,
                TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket => {
                    depth = depth.saturating_sub(1);
                }
                _ => {}
            }
            is_line_start = false;
        }
        None
    }

    /// The header whose first bracket was just read, and how many brackets stay open if it is none.
    fn header(&mut self) -> (Header, usize) {
        let mut keys: [&str; 2] = [""; 2];
        let (mut count, mut opened) = (0, 1);
        while let Some(token) = self.tokens.peek() {
            let (text, span) = (self.text, token.span());
            match token.kind() {
                TokenKind::LeftSquareBracket if count == 0 && opened == 1 => opened = 2,
                TokenKind::Atom | TokenKind::BasicString | TokenKind::LiteralString => {
                    if let Some(key) = keys.get_mut(count) {
                        *key = text[span.start()..span.end()].trim_matches(['"', '\'']);
                    }
                    count += 1;
                }
                TokenKind::Whitespace | TokenKind::Dot => {}
                _ => break,
            }
            self.tokens.next();
        }
        let header = match (opened, count, keys) {
            (2, 1, ["sphere", _]) => Header::Begins(Kind::Sphere),
            (1, 2, ["materials", _]) => Header::Begins(Kind::Material),
            (_, 2.., ["sphere", _]) => Header::WithinSphere,
            _ => Header::Begins(Kind::Head),
        };
        (header, opened)
    }
}

impl Iterator for Pieces<'_> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        let (kind, start) = self.next?;
        let begun = loop {
            match self.next_header() {
                Some((Header::WithinSphere, _)) if kind == Kind::Sphere => {}
                Some((Header::WithinSphere, at)) => break Some((Kind::Head, at)),
                Some((Header::Begins(kind), at)) => break Some((kind, at)),
                None => break None,
            }
        };
        let end = begun.map_or(self.text.len(), |(_, at)| at);
        self.next = begun;
        Some(Piece { kind, span: start..end })
    }
}

impl Piece {
    /// Parses the piece and passes its root to `read`. Faults are placed in the whole text.
    pub(super) fn parse<'a, T>(
        &self,
        text: &'a str,
        read: impl FnOnce(&DeTable<'a>) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let piece = &text[self.span.clone()];
        let parsed = check_length(piece.len(), 0).and_then(|()| {
            let document = DeTable::parse(piece).map_err(|error| syntax_fault(piece, &error))?;
            read(document.get_ref())
        });
        parsed.map_err(|fault| Fault { at: fault.at + self.span.start, ..fault })
    }
}

/// The head of a scene: all pieces that are neither spheres nor materials, as one text.
#[derive(Default)]
pub(super) struct Head {
    pub(super) text: String,
    /// Where each of its pieces begins, in `text` and in the whole text.
    places: Vec<(usize, usize)>,
}

impl Head {
    /// Appends `piece` of `text`.
    pub(super) fn push(&mut self, text: &str, piece: &Piece) -> Result<(), Fault> {
        check_length(self.text.len() + piece.span.len(), piece.span.start)?;
        self.places.push((self.text.len(), piece.span.start));
        self.text.push_str(&text[piece.span.clone()]);
        Ok(())
    }

    /// `fault`, which is placed in the head, placed in the whole text.
    pub(super) fn fault(&self, fault: Fault) -> Fault {
        Fault { at: self.place(fault.at), ..fault }
    }

    /// The place in the whole text of byte `at` of the head.
    pub(super) fn place(&self, at: usize) -> usize {
        let before = self.places.partition_point(|(begin, _)| *begin <= at);
        let (begin, there) = self.places[before.saturating_sub(1)];
        there + (at - begin)
    }
}

fn check_length(bytes: usize, at: usize) -> Result<(), Fault> {
    if bytes <= MOST_BYTES {
        return Ok(());
    }
    let message = format!(
        "this takes more than {MOST_BYTES} bytes; head every sphere with [[sphere]] and every material with \
         [materials.NAME], and shorten comments"
    );
    Err(Fault::new(at, message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Kind::{Head, Material, Sphere};

    fn pieces(text: &str) -> Vec<(Kind, &str)> {
        Pieces::new(text).map(|piece| (piece.kind, &text[piece.span])).collect()
    }

    #[test]
    fn tables_are_split_at_their_headers() {
        let text = "name = \"[[sphere]]\" # [[sphere]]\n[camera]\neye = [\n[[1]],\n]\n\
            [materials.a]\nx = 1\n [[sphere]] # one\nr = '''\n[[sphere]]\n'''\n[sphere.material]\n\
            [[ \"sphere\" ]]\n[materials]\n[sphere.material]\n[[materials.b]]\n[materials.b.c]\n";
        let expected = [
            (Head, "name = \"[[sphere]]\" # [[sphere]]\n"),
            (Head, "[camera]\neye = [\n[[1]],\n]\n"),
            (Material, "[materials.a]\nx = 1\n "),
            (Sphere, "[[sphere]] # one\nr = '''\n[[sphere]]\n'''\n[sphere.material]\n"),
            (Sphere, "[[ \"sphere\" ]]\n"),
            (Head, "[materials]\n"),
            (Head, "[sphere.material]\n"),
            (Head, "[[materials.b]]\n"),
            (Head, "[materials.b.c]\n"),
        ];
        assert_eq!(pieces(text), expected);
    }

    #[test]
    fn a_bracket_that_is_never_closed_spoils_one_sphere() {
        let text = "[[sphere]]\nc = [1, [2\n[materials.a]\n[[sphere]]\nc = {\n";
        let first = "[[sphere]]\nc = [1, [2\n[materials.a]\n";
        assert_eq!(pieces(text), [(Head, ""), (Sphere, first), (Sphere, "[[sphere]]\nc = {\n")]);
    }

    #[test]
    fn places_in_the_head_are_places_in_the_text() {
        let text = "a = 1\n[[sphere]]\n[b]\nc = 2\n";
        let mut head = super::Head::default();
        for piece in Pieces::new(text).filter(|piece| piece.kind == Head) {
            head.push(text, &piece).unwrap();
        }
        assert_eq!(head.text, "a = 1\n[b]\nc = 2\n");
        for (at, byte) in head.text.bytes().enumerate() {
            assert_eq!(text.as_bytes()[head.place(at)], byte);
        }
    }
}
