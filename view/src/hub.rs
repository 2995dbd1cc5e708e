//! What the source of pictures and the clients of the server share.

use crate::inbox::Inbox;
use crate::kept::Kept;
use crate::message::{Answer, Request};
use crate::picture::Picture;
use axum::body::Bytes;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::{mpsc, watch};

/// Most layers of an image.
pub(crate) const MAX_LAYERS: usize = 64;
/// So many requests may wait. A client whose request finds no room waits with it.
const MAX_REQUESTS: usize = 64;
/// So many images stay ready for download.
const MAX_KEPT: usize = 2;

/// A request of a client, and where the answer goes.
#[derive(Debug)]
pub(crate) struct Asked {
    pub(crate) request: Request,
    answers: mpsc::Sender<Answer>,
}

impl Asked {
    pub(crate) fn new(request: Request, answers: mpsc::Sender<Answer>) -> Self {
        Self { request, answers }
    }

    /// Answers. A client that does not read its answers loses them.
    pub(crate) fn answer(&self, answer: Answer) {
        let _ = self.answers.try_send(answer);
    }
}

/// Texts in JSON that every client gets: first the newest, then each that follows, but for those that it is too slow for.
pub(crate) type Board = watch::Sender<Arc<str>>;

/// What the source of pictures and the clients share.
#[derive(Debug)]
pub(crate) struct Hub {
    pub(crate) pictures: watch::Sender<Option<Arc<Picture>>>,
    /// The spheres and materials; in other modes what is shown.
    pub(crate) scene: Board,
    /// Camera, settings and engine.
    pub(crate) setup: Board,
    /// Progress.
    pub(crate) status: Board,
    /// Requests, for sources that take some.
    pub(crate) requests: Inbox<Asked>,
    pub(crate) takes_requests: bool,
    /// Images to compare with, each with its name.
    pub(crate) others: Vec<(String, Bytes)>,
    kept: Mutex<VecDeque<Arc<Kept>>>,
    clients: AtomicUsize,
    /// How long the quickest page took for the last picture, in microseconds; see [`Hub::drawing_time`].
    drawing: AtomicU64,
    /// How many clients look at each layer.
    wanted: [AtomicUsize; MAX_LAYERS],
}

impl Hub {
    /// A hub of a source that takes requests, or does not.
    pub(crate) fn new(takes_requests: bool, others: Vec<(String, Bytes)>) -> Self {
        let empty = || watch::Sender::new(Arc::from(""));
        Self {
            pictures: watch::Sender::new(None),
            scene: empty(),
            setup: empty(),
            status: empty(),
            requests: Inbox::new(MAX_REQUESTS),
            takes_requests,
            others,
            kept: Mutex::default(),
            clients: AtomicUsize::new(0),
            drawing: AtomicU64::new(0),
            wanted: [const { AtomicUsize::new(0) }; MAX_LAYERS],
        }
    }

    /// Registers a client, unless there are `most` already.
    pub(crate) fn enter(self: &Arc<Self>, most: usize) -> Option<Visit> {
        let room = |clients| (clients < most).then_some(clients + 1);
        self.clients.fetch_update(Ordering::Relaxed, Ordering::Relaxed, room).ok()?;
        self.wanted[0].fetch_add(1, Ordering::Relaxed);
        self.requests.ring();
        Some(Visit { hub: Arc::clone(self), layer: 0 })
    }

    /// The number of clients.
    pub(crate) fn clients(&self) -> usize {
        self.clients.load(Ordering::Relaxed)
    }

    /// Notes that a page has drawn a picture, so long after it was sent.
    pub(crate) fn note_drawn(&self, picture: &Picture, taken: Duration) {
        if picture.note_drawn() {
            self.drawing.store(taken.as_micros() as u64, Ordering::Relaxed);
        }
    }

    /// The time in which the last picture was sent and drawn, by the page that was first.
    pub(crate) fn drawing_time(&self) -> Duration {
        Duration::from_micros(self.drawing.load(Ordering::Relaxed))
    }

    /// The layers that somebody looks at; if nobody does, the first.
    pub(crate) fn wanted(&self) -> Vec<u32> {
        let is_wanted = |layer: &u32| self.wanted[*layer as usize].load(Ordering::Relaxed) > 0;
        let all: Vec<u32> = (0..MAX_LAYERS as u32).filter(is_wanted).collect();
        if all.is_empty() { vec![0] } else { all }
    }

    /// Makes an image ready for download.
    pub(crate) fn keep(&self, kept: Arc<Kept>) {
        let mut all = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        all.push_back(kept);
        if all.len() > MAX_KEPT {
            all.pop_front();
        }
    }

    /// The image `number`, if it is still ready for download.
    pub(crate) fn kept(&self, number: u32) -> Option<Arc<Kept>> {
        let all = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().find(|kept| kept.number == number).cloned()
    }
}

/// Shows a text to all clients.
pub(crate) fn show(board: &Board, text: &serde_json::Value) {
    board.send_replace(text.to_string().into());
}

/// A client's place in the hub, which it leaves when this is dropped.
#[derive(Debug)]
pub(crate) struct Visit {
    hub: Arc<Hub>,
    layer: usize,
}

impl Visit {
    /// Looks at another layer.
    pub(crate) fn look_at(&mut self, layer: usize) {
        self.hub.wanted[self.layer].fetch_sub(1, Ordering::Relaxed);
        self.layer = layer.min(MAX_LAYERS - 1);
        self.hub.wanted[self.layer].fetch_add(1, Ordering::Relaxed);
        self.hub.requests.ring();
    }

    /// The layer that it looks at.
    pub(crate) fn layer(&self) -> u32 {
        self.layer as u32
    }
}

impl Drop for Visit {
    fn drop(&mut self) {
        self.hub.wanted[self.layer].fetch_sub(1, Ordering::Relaxed);
        self.hub.clients.fetch_sub(1, Ordering::Relaxed);
        self.hub.requests.ring();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_wanted_as_long_as_somebody_looks_at_them() {
        let hub = Arc::new(Hub::new(true, Vec::new()));
        assert_eq!((hub.wanted(), hub.clients()), (vec![0], 0));
        let mut one = hub.enter(2).unwrap();
        let mut two = hub.enter(2).unwrap();
        assert!(hub.enter(2).is_none());
        one.look_at(3);
        assert_eq!((hub.wanted(), one.layer(), hub.clients()), (vec![0, 3], 3, 2));
        two.look_at(3);
        assert_eq!(hub.wanted(), [3]);
        one.look_at(MAX_LAYERS + 9);
        assert_eq!(hub.wanted(), [3, MAX_LAYERS as u32 - 1]);
        drop((one, two));
        assert_eq!((hub.wanted(), hub.clients()), (vec![0], 0));
    }

    #[test]
    fn the_quickest_page_tells_the_drawing_time() {
        let hub = Hub::new(true, Vec::new());
        let [first, second] = [(); 2].map(|()| Picture::new(Vec::new()));
        let after = |picture: &Picture, milliseconds: u64| {
            hub.note_drawn(picture, Duration::from_millis(milliseconds));
            hub.drawing_time().as_millis()
        };
        assert_eq!(after(&first, 20), 20);
        assert_eq!(after(&first, 5000), 20);
        assert_eq!(after(&second, 30), 30);
    }
}
