//! The live view of renders and images: a web server with a page for the browser, and the protocol of tev.
//!
//! [`View::studio`] serves a scene that is edited in the page and rendered again after every change. [`View::files`] serves
//! image files, [`View::relay`] a render that runs elsewhere. Of each, [`View::address`] is the page's address, with a
//! random token that every request must carry. See `docs/view.md`.
//!
//! The server runs on a thread of its own; a page that is slow, or sends nonsense, slows nobody (`client.rs`).

#![forbid(unsafe_code)]

mod client;
mod display;
mod easel;
mod gallery;
mod gate;
mod hub;
mod inbox;
mod kept;
mod listener;
mod message;
mod model;
mod pace;
mod page;
mod pick;
mod picture;
mod place;
mod relay;
pub mod rgb9e5;
mod server;
mod studio;
pub mod tev;

pub use display::Display;
pub use kept::{Download, Kept, Look};
pub use picture::HEADER;
pub use place::Place;
pub use relay::Relay;
pub use studio::{Legacy, Project, bytes_at_most};

use files::atomic_file::reason;
use hub::Hub;
use scene::Stop;
use server::Server;
use std::path::Path;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// A page that is served. Dropping it ends the server.
#[derive(Debug)]
pub struct View {
    server: Server,
    hub: Arc<Hub>,
    quit: Stop,
    studio: Option<JoinHandle<Legacy>>,
}

impl View {
    /// Serves a scene to be edited. `reference` is an image to compare with.
    ///
    /// # Errors
    /// If the reference cannot be read, or if the system denies the port or a thread: one line.
    pub fn studio(
        project: Project,
        reference: Option<&Path>,
        display: Option<Arc<Display>>,
        place: &Place,
    ) -> Result<Self, String> {
        let others = reference.map(|path| gallery::other(path, None)).transpose()?;
        let hub = Arc::new(Hub::new(true, others.into_iter().collect()));
        let mut view = Self::serve(hub, place)?;
        let (hub, quit) = (Arc::clone(&view.hub), view.quit.clone());
        let work = move || studio::Studio::new(project, hub, display).run(&quit);
        let begun = thread::Builder::new().name("studio".into()).spawn(work);
        view.studio = Some(begun.map_err(|error| format!("cannot start a thread: {}", reason(&error)))?);
        Ok(view)
    }

    /// Serves the image file `path`, and another to compare it with.
    ///
    /// # Errors
    /// If a file cannot be read, or if the system denies the port or a thread: one line.
    pub fn files(
        path: &Path,
        layer: Option<&str>,
        other: Option<&Path>,
        place: &Place,
    ) -> Result<Self, String> {
        let others = other.map(|path| gallery::other(path, None)).transpose()?;
        Self::serve(Arc::new(gallery::open(path, layer, others.into_iter().collect())?), place)
    }

    /// Serves two image files to be compared, each in the layer of that name where one is named.
    ///
    /// # Errors
    /// As [`Self::files`].
    pub fn compared(
        (a, layer): (&Path, Option<&str>),
        (b, layer_of_b): (&Path, Option<&str>),
        place: &Place,
    ) -> Result<Self, String> {
        let other = gallery::other(b, layer_of_b)?;
        Self::serve(Arc::new(gallery::open(a, layer, vec![other])?), place)
    }

    /// Serves a render of the scene `name`, which the relay is told of after every iteration. Without a place there is no
    /// server: the relay serves the display alone.
    ///
    /// # Errors
    /// If the system denies the port or a thread: one line.
    pub fn relay(
        name: &str,
        display: Option<Arc<Display>>,
        place: Option<&Place>,
    ) -> Result<(Option<Self>, Relay), String> {
        let view =
            place.map(|place| Self::serve(Arc::new(Hub::new(false, Vec::new())), place)).transpose()?;
        let relay = Relay::new(view.as_ref().map(|view| Arc::clone(&view.hub)), display, name);
        Ok((view, relay))
    }

    fn serve(hub: Arc<Hub>, place: &Place) -> Result<Self, String> {
        let server = Server::start(Arc::clone(&hub), place)?;
        Ok(Self { server, hub, quit: Stop::new(), studio: None })
    }

    /// The address of the page, with its token.
    pub fn address(&self) -> &str {
        &self.server.address
    }

    /// Opens the page in the browser of this machine, if it has one; the address is enough where there is none.
    pub fn open(&self) {
        if has_screen() {
            let _ = open::that_detached(self.address());
        }
    }

    /// Ends, and returns what became of the scene; `None` for what is not edited.
    pub fn end(mut self) -> Option<Legacy> {
        self.quit.request();
        self.studio.take().and_then(|studio| studio.join().ok())
    }
}

impl Drop for View {
    fn drop(&mut self) {
        self.quit.request();
        if let Some(studio) = self.studio.take() {
            let _ = studio.join(); // there is nobody to tell that it panicked
        }
    }
}

/// Whether a browser can open a window: on Linux and the like a display server must be there, as else a browser in text would
/// take the terminal.
fn has_screen() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(target_os = "macos", windows)) || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}
