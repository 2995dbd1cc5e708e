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

impl Default for Place {
    /// This machine alone, at any port.
    fn default() -> Self {
        Self { ip: [127, 0, 0, 1].into(), port: 0, token: None }
    }
}
