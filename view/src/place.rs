//! Where a server listens.

use std::net::IpAddr;

/// Where a server listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The address; the loopback address keeps other machines out.
    pub ip: IpAddr,
    /// The port; 0 is any that is free.
    pub port: u16,
    /// The token of the page's address; a random one if not given.
    pub token: Option<String>,
}

/// The environment variable that may hold the token. It is not an option, as other users of the machine can see those.
const TOKEN: &str = "SPPM_VIEW_TOKEN";

impl Place {
    /// At this address and port, or the usual ones; the token may be in the environment, by the name `SPPM_VIEW_TOKEN`.
    pub fn new(ip: Option<IpAddr>, port: Option<u16>) -> Self {
        Self::with_token(ip, port, std::env::var(TOKEN).ok())
    }

    /// The same with this token, which counts as not given if it is empty.
    fn with_token(ip: Option<IpAddr>, port: Option<u16>, token: Option<String>) -> Self {
        let usual = Self::default();
        let token = token.filter(|token| !token.is_empty());
        Self { ip: ip.unwrap_or(usual.ip), port: port.unwrap_or(usual.port), token }
    }
}

impl Default for Place {
    /// This machine alone, at any port.
    fn default() -> Self {
        Self { ip: [127, 0, 0, 1].into(), port: 0, token: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty variable of the environment is how some shells and services unset one.
    #[test]
    fn what_is_not_given_or_empty_is_as_usual() {
        let (ip, token) = (IpAddr::from([0, 0, 0, 0]), "0123456789abcdef");
        let usual = Place::default();
        assert_eq!(Place::with_token(None, None, None), usual);
        assert_eq!(Place::with_token(None, None, Some(String::new())), usual);
        assert_eq!(Place::with_token(Some(ip), None, None), Place { ip, ..usual.clone() });
        assert_eq!(Place::with_token(None, Some(8000), None), Place { port: 8000, ..usual.clone() });
        let given = Place { token: Some(token.into()), ..usual };
        assert_eq!(Place::with_token(None, None, Some(token.into())), given);
    }
}
