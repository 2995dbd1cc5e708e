//! Who may talk to the server: the token in the address, and the headers that tell one's own page from a foreign one.
//!
//! Any page in the browser can send requests to a server on the same machine. It cannot know the token. A page that makes
//! its own name lead to this machine (DNS rebinding) sends that name as `Host`; a page that opens a websocket, for which
//! browsers have no same-origin rule, sends where it is from as `Origin`.

use axum::http::HeaderMap;
use axum::http::header::{HOST, ORIGIN};
use std::fmt::Write;
use std::net::IpAddr;

/// Random bytes of a token.
const TOKEN_BYTES: usize = 16;

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    Host,
    Origin,
    Token,
}

impl Refusal {
    /// What is told to who asked.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Host => "Refused: open this page by an IP address or as localhost, not by another name.\n",
            Self::Origin => "Refused: another page asked for this.\n",
            Self::Token => {
                "Refused: the address lacks the right token; copy the whole address that sppm printed.\n"
            }
        }
    }
}

/// A new token: 128 random bits in hexadecimal.
pub(crate) fn new_token() -> Result<String, String> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes).map_err(|error| format!("cannot make a token: {error}"))?;
    let mut text = String::new();
    for byte in bytes {
        let _ = write!(text, "{byte:02x}"); // writing to a String cannot fail
    }
    Ok(text)
}

/// A token that somebody chose.
pub(crate) fn given_token(token: &str) -> Result<String, String> {
    /// Letters and digits, so that nobody guesses it.
    const LEAST: usize = 16;
    let is_plain = token.bytes().all(|byte| byte.is_ascii_alphanumeric());
    if is_plain && token.len() >= LEAST {
        return Ok(token.into());
    }
    Err(format!("the token of the page must be at least {LEAST} letters and digits"))
}

/// Checks a request with this token in its address.
pub(crate) fn check(headers: &HeaderMap, given: &str, token: &str) -> Result<(), Refusal> {
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
    let host = text(HOST).filter(|host| is_own(host)).ok_or(Refusal::Host)?;
    // Programs other than browsers send none.
    if text(ORIGIN).is_some_and(|origin| origin.strip_prefix("http://") != Some(host)) {
        return Err(Refusal::Origin);
    }
    if is_same(given.as_bytes(), token.as_bytes()) { Ok(()) } else { Err(Refusal::Token) }
}

/// Whether `host` is `localhost` or an IP address, with any port: what no foreign page can be reached by. Ports differ from
/// the server's where they are forwarded, as by `ssh -L`.
fn is_own(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.parse::<u16>().is_ok() => name,
        _ => host,
    };
    let inner = name.strip_prefix('[').and_then(|name| name.strip_suffix(']'));
    name.eq_ignore_ascii_case("localhost") || inner.unwrap_or(name).parse::<IpAddr>().is_ok()
}

/// Compares in a time that does not tell where they differ.
fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |bits, (a, b)| bits | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(host: &str, origin: Option<&str>, token: &str) -> Result<(), Refusal> {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(ORIGIN, origin.parse().unwrap());
        }
        check(&headers, token, "0123")
    }

    #[test]
    fn only_ones_own_page_gets_in() {
        for host in ["127.0.0.1:80", "localhost:1234", "LOCALHOST", "[::1]:9", "192.168.1.7:9", "[::1]"] {
            assert_eq!(verdict(host, None, "0123"), Ok(()), "{host}");
            assert_eq!(verdict(host, Some(&format!("http://{host}")), "0123"), Ok(()), "{host}");
        }
        for host in
            ["evil.example", "evil.example:80", "localhost.evil.example", "127.0.0.1.evil.example", ""]
        {
            assert_eq!(verdict(host, None, "0123"), Err(Refusal::Host), "{host}");
        }
        for origin in ["http://evil.example", "null", "https://127.0.0.1:80", "http://127.0.0.1:81", ""] {
            assert_eq!(verdict("127.0.0.1:80", Some(origin), "0123"), Err(Refusal::Origin), "{origin}");
        }
        for token in ["", "0124", "01234", "012"] {
            assert_eq!(verdict("localhost", None, token), Err(Refusal::Token), "{token}");
        }
        assert_eq!(check(&HeaderMap::new(), "0123", "0123"), Err(Refusal::Host));
    }

    #[test]
    fn tokens_are_long_and_differ() {
        let (a, b) = (new_token().unwrap(), new_token().unwrap());
        assert_eq!(a.len(), 2 * TOKEN_BYTES);
        assert_ne!(a, b);
        assert_eq!(given_token(&a), Ok(a));
        assert!(given_token("tooshort").is_err() && given_token("no/path/no/path/no").is_err());
        // As the help says: at least 16 letters and digits.
        assert!(given_token("0123456789abcdeF").is_ok() && given_token("0123456789abcde").is_err());
    }
}
