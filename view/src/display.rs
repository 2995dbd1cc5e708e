//! Sends the image of a render to tev: on a thread of its own, only the tiles that changed, and the newest image first.
//!
//! The render leaves an image when the last one is sent, and never waits. When the viewer is gone the thread looks for it
//! again and sends everything when it is back.

use crate::tev::{Tile, create, update};
use files::atomic_file::reason;
use scene::{Film, Rgb};
use std::fmt;
use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The side of a tile, in pixels.
const SIDE: u32 = 128;
/// The least time between two images.
const INTERVAL: Duration = Duration::from_millis(250);
/// What takes longer to send counts as a viewer that is gone.
const PATIENCE: Duration = Duration::from_secs(3);
/// How often a viewer that is gone is looked for.
const RETRY: Duration = Duration::from_millis(500);
/// How long the last image may take, at the end.
const LAST: Duration = Duration::from_secs(3);

/// A viewer that images are sent to. Dropping it sends the last one, if the viewer is there.
pub struct Display {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl fmt::Debug for Display {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Display").finish_non_exhaustive()
    }
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// The newest image, if it is not being sent yet.
    next: Option<Film>,
    is_sending: bool,
    last: Option<Instant>,
    quits: bool,
}

impl Display {
    /// A viewer at `place`, such as `localhost:14158`. The image is called `name` there.
    ///
    /// # Errors
    /// If the system denies a thread.
    pub fn new(place: String, name: String) -> Result<Self, String> {
        Self::telling(place, name, |_| {})
    }

    /// As [`Display::new`]; `tell` is called with a line when the viewer is not there, once until it is.
    ///
    /// # Errors
    /// As [`Display::new`].
    pub fn telling(
        place: String,
        name: String,
        tell: impl Fn(&str) + Send + 'static,
    ) -> Result<Self, String> {
        let shared = Arc::new(Shared::default());
        let tell = Box::new(tell);
        let sender = Sender {
            place,
            name,
            shared: Arc::clone(&shared),
            stream: None,
            sent: None,
            tell,
            is_told: false,
        };
        let begun = thread::Builder::new().name("display".into()).spawn(move || sender.run());
        let thread = begun.map_err(|error| format!("cannot start a thread: {}", reason(&error)))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Whether an image is welcome: the last one is sent, and some time ago.
    pub fn is_due(&self) -> bool {
        let state = self.shared.lock();
        state.next.is_none() && !state.is_sending && state.last.is_none_or(|at| at.elapsed() >= INTERVAL)
    }

    /// Leaves an image to be sent. One that waits is replaced.
    pub fn show(&self, film: Film) {
        let mut state = self.shared.lock();
        (state.next, state.last) = (Some(film), Some(Instant::now()));
        self.shared.changed.notify_all();
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.shared.lock().quits = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // there is nobody to tell that it panicked
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for an image; `None` at the end.
    fn take(&self) -> Option<Film> {
        let mut state = self.lock();
        loop {
            if let Some(film) = state.next.take() {
                state.is_sending = true;
                return Some(film);
            }
            if state.quits {
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits before the viewer is looked for again. Returns the image to be sent then, or `None` at the end.
    fn retry(&self, film: Film) -> Option<Film> {
        let is_idle = |state: &mut State| !state.quits;
        let waited = self.changed.wait_timeout_while(self.lock(), RETRY, is_idle);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        if state.quits { None } else { Some(state.next.take().unwrap_or(film)) }
    }
}

struct Sender {
    place: String,
    name: String,
    shared: Arc<Shared>,
    stream: Option<TcpStream>,
    /// What the viewer shows.
    sent: Option<Film>,
    tell: Box<dyn Fn(&str) + Send>,
    /// Whether it was told that the viewer is not there.
    is_told: bool,
}

impl Sender {
    fn run(mut self) {
        while let Some(mut film) = self.shared.take() {
            while let Err(error) = self.send(&film) {
                (self.stream, self.sent) = (None, None);
                self.miss(&error);
                let Some(next) = self.shared.retry(film) else { return };
                film = next;
            }
            (self.sent, self.is_told) = (Some(film), false);
            self.shared.lock().is_sending = false;
        }
    }

    /// Tells that the viewer is not there.
    fn miss(&mut self, error: &io::Error) {
        if !std::mem::replace(&mut self.is_told, true) {
            let Self { place, .. } = self;
            let why = reason(error);
            (self.tell)(&format!(
                "no viewer is reached at {place} ({why}); it is looked for until there is one"
            ));
        }
    }

    fn send(&mut self, film: &Film) -> io::Result<()> {
        let until = Instant::now() + LAST;
        let is_known =
            self.sent.as_ref().is_some_and(|sent| [sent.width, sent.height] == [film.width, film.height]);
        let before = self.sent.as_ref().filter(|_| is_known);
        let mut stream = match self.stream.take() {
            Some(stream) if is_there(&stream) => stream,
            Some(_) => return Err(io::ErrorKind::ConnectionReset.into()),
            None => connect(&self.place)?,
        };
        if before.is_none() {
            stream.write_all(&create(&self.name, film.width, film.height))?;
        }
        for tile in tiles(film.width, film.height) {
            let new = pixels(film, tile);
            if before.is_some_and(|before| same(&pixels(before, tile), &new)) {
                continue;
            }
            stream.write_all(&update(&self.name, tile, &new))?;
            if self.shared.lock().quits && Instant::now() > until {
                break;
            }
        }
        self.stream = Some(stream);
        Ok(())
    }
}

fn connect(place: &str) -> io::Result<TcpStream> {
    let mut last = io::ErrorKind::NotFound.into();
    for address in place.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE))?;
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Whether the viewer has not closed the connection. It sends nothing, so that anything to read is the end.
fn is_there(stream: &TcpStream) -> bool {
    let nothing = || -> io::Result<bool> {
        stream.set_nonblocking(true)?;
        let peeked = stream.peek(&mut [0]);
        stream.set_nonblocking(false)?;
        Ok(matches!(peeked, Err(error) if error.kind() == io::ErrorKind::WouldBlock))
    };
    nothing().unwrap_or(false)
}

/// The tiles of an image, row by row.
fn tiles(width: u32, height: u32) -> impl Iterator<Item = Tile> {
    let side = |at: u32, all: u32| SIDE.min(all - at);
    let row = move |y| (0..width).step_by(SIDE as usize).map(move |x| (x, y));
    let places = (0..height).step_by(SIDE as usize).flat_map(row);
    places.map(move |(x, y)| Tile { x, y, width: side(x, width), height: side(y, height) })
}

fn pixels(film: &Film, tile: Tile) -> Vec<f32> {
    let row = |y: u32| {
        let start = (y as usize) * film.width as usize + tile.x as usize;
        &film.pixels[start..][..tile.width as usize]
    };
    (tile.y..tile.y + tile.height).flat_map(row).flat_map(|pixel: &Rgb| pixel.to_array()).collect()
}

/// Whether two tiles have the same bits; NaN is like itself.
fn same(a: &[f32], b: &[f32]) -> bool {
    a.iter().map(|v| v.to_bits()).eq(b.iter().map(|v| v.to_bits()))
}
