//! Options for the live view: where its page is served, and a viewer that images are sent to.

use crate::args::values::whole;
use crate::terminal::error::Error;
use crate::terminal::logs::{Level, say};
use crate::terminal::text::print;
use clap::Args as ClapArgs;
use std::net::IpAddr;
use std::sync::Arc;
use view::{Display, Place, Relay, View, tev};

/// Where the page is served.
#[derive(Clone, Debug, Default, ClapArgs)]
#[command(next_help_heading = "Page")]
pub(crate) struct PageArgs {
    /// Serve the page at this port [default: any that is free]
    ///
    /// With `SPPM_VIEW_TOKEN` in the environment, at least 16 letters and digits, the address stays the same from one view to
    /// the next, and an open page finds the next one.
    #[arg(long, value_name = "PORT", value_parser = whole::<u16>(1, u16::MAX.into()), allow_hyphen_values = true)]
    pub port: Option<u16>,

    /// Serve it at this address of the machine, such as 0.0.0.0 for all of them [default: 127.0.0.1]
    ///
    /// By default only programs on this machine can reach the page, and they need its whole address, which holds a random
    /// token. Elsewhere the token is all that keeps others out, and it travels without encryption: prefer a tunnel, such as
    /// `ssh -L`.
    #[arg(long, value_name = "ADDRESS", value_parser = address, allow_hyphen_values = true)]
    pub listen: Option<IpAddr>,

    /// Do not open the page in the browser
    #[arg(long)]
    pub no_open: bool,
}

fn address(text: &str) -> Result<IpAddr, String> {
    text.parse().map_err(|_| "is not the number of an address, such as 0.0.0.0 or 192.168.1.7".into())
}

impl PageArgs {
    /// Where the page is to be served.
    pub(crate) fn place(&self) -> Place {
        Place::new(self.listen, self.port)
    }

    /// Refuses these options where no page is asked for.
    pub(crate) fn check(&self, has_page: bool) -> Result<(), Error> {
        let given = [
            ("--port", self.port.is_some()),
            ("--listen", self.listen.is_some()),
            ("--no-open", self.no_open),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given && !has_page) {
            Some((option, _)) => {
                Err(Error::BadInput(format!("{option}: is of the page; ask for it by --view")))
            }
            None => Ok(()),
        }
    }

    /// Prints the address of the page, to standard output unless `is_taken`, and opens it in the browser.
    pub(crate) fn announce(&self, view: &View, is_taken: bool) -> Result<(), Error> {
        if is_taken {
            say(Level::WARN, &format!("the page is at {}", view.address()));
        } else {
            print(format!("{}\n", view.address()).as_bytes())?;
        }
        if !self.no_open {
            view.open();
        }
        Ok(())
    }
}

/// A viewer that images are sent to.
#[derive(Clone, Debug, Default, ClapArgs)]
#[command(next_help_heading = "Viewers")]
pub(crate) struct DisplayArgs {
    /// Send the image, as it converges, to the viewer tev (or `HDRView`) that listens there [default port: 14158]
    ///
    /// The render never waits for the viewer, which may be closed and opened again.
    #[arg(long, value_name = "HOST[:PORT]")]
    pub display: Option<String>,
}

impl DisplayArgs {
    /// The viewer, in which the image is called `name`.
    pub(crate) fn start(&self, name: &str) -> Result<Option<Arc<Display>>, Error> {
        let start = |place: &str| {
            let place =
                tev::place(place).map_err(|problem| Error::BadInput(format!("--display {problem}")))?;
            Display::telling(place, name.into(), |problem| say(Level::WARN, &format!("--display: {problem}")))
                .map_err(Error::Failed)
        };
        Ok(self.display.as_deref().map(start).transpose()?.map(Arc::new))
    }
}

/// Watching a render that runs.
#[derive(Clone, Debug, Default, ClapArgs)]
#[command(next_help_heading = "Viewers")]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    pub page: PageArgs,

    #[command(flatten)]
    pub display: DisplayArgs,
}

impl WatchArgs {
    /// Serves the page, if there is to be one, and finds the viewer that is asked for, for a render of the scene `name`.
    /// Standard output may be taken by something else than the page's address.
    pub(crate) fn start(
        &self,
        has_page: bool,
        name: &str,
        is_taken: bool,
    ) -> Result<Option<(Option<View>, Relay)>, Error> {
        self.page.check(has_page)?;
        if !has_page && self.display.display.is_none() {
            return Ok(None);
        }
        let display = self.display.start(name)?;
        let place = has_page.then(|| self.page.place());
        let (view, relay) = View::relay(name, display, place.as_ref()).map_err(Error::BadInput)?;
        if let Some(view) = &view {
            self.page.announce(view, is_taken)?;
        }
        Ok(Some((view, relay)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::of_render;

    #[test]
    fn options_of_the_page_need_one() {
        let page = |words: &[&str]| of_render(&[&["cornell"], words].concat()).viewers.page;
        for words in [&["--port", "8000"][..], &["--listen", "0.0.0.0"], &["--no-open"]] {
            let problem = page(words).check(false).unwrap_err().to_string();
            assert_eq!(problem, format!("{}: is of the page; ask for it by --view", words[0]));
            assert!(page(words).check(true).is_ok());
        }
        assert!(page(&[]).check(false).is_ok());
        assert!(address("0.0.0.0").is_ok() && address("::1").is_ok());
        assert!(address("localhost").unwrap_err().starts_with("is not the number of an address"));
    }

    #[test]
    fn a_page_is_served_where_it_is_asked_for() {
        let place = |words: &[&str]| {
            let place = of_render(&[&["cornell"], words].concat()).viewers.page.place();
            (place.ip.to_string(), place.port)
        };
        assert_eq!(place(&[]), ("127.0.0.1".into(), 0));
        assert_eq!(place(&["--listen", "0.0.0.0", "--port", "8000"]), ("0.0.0.0".into(), 8000));
    }

    #[test]
    fn nothing_is_watched_unless_it_is_asked_for() {
        let watch = |words: &[&str]| of_render(&[&["cornell"], words].concat()).viewers;
        assert!(watch(&[]).start(false, "a", false).unwrap().is_none());
        assert!(watch(&["--no-open"]).start(false, "a", false).is_err());
        let started = watch(&["--no-open"]).start(true, "a", true).unwrap();
        assert!(started.is_some_and(|(view, _)| {
            view.is_some_and(|view| view.address().starts_with("http://127.0.0.1:"))
        }));
        let problem = watch(&["--display", "a:b"]).start(false, "a", false).err().unwrap().to_string();
        assert!(problem.starts_with("--display "), "{problem}");
    }
}
