//! One page: sends it pictures and progress, and passes on what it asks for.
//!
//! A picture is sent when the page has drawn the one before; then the newest, so a slow page skips pictures. It holds at
//! most one picture and slows nobody. Requests are read only as fast as [`RATE`] allows; what comes faster waits in the
//! network.

use crate::hub::{Asked, Hub, MAX_LAYERS, Visit};
use crate::message::{Answer, Request};
use crate::picture::Picture;
use axum::extract::ws::{CloseFrame, Message, WebSocket};
use serde::Serialize;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, watch};
use tokio::time::{sleep, timeout};

/// Longer messages of a page end the connection.
pub(crate) const MAX_MESSAGE: usize = 1 << 14;
/// Messages of a page per second, and at once.
const RATE: f64 = 240.0;
const BURST: f64 = 480.0;
/// So many messages that mean nothing end the connection.
const MAX_BAD: u32 = 16;
/// Answers that may wait for a page.
const MAX_ANSWERS: usize = 16;
/// What takes longer to send ends the connection.
const PATIENCE: Duration = Duration::from_secs(30);
/// How long a request waits before it is offered again.
const BUSY: Duration = Duration::from_millis(5);
/// Why a connection ends (RFC 6455, section 7.4.1).
const POLICY: u16 = 1008;

/// Why a page is left.
struct Left;

/// Serves a page until it leaves.
pub(crate) async fn serve(socket: WebSocket, hub: Arc<Hub>, visit: Visit) {
    let (answers, mail) = mpsc::channel(MAX_ANSWERS);
    let (pictures, budget) = (hub.pictures.subscribe(), Budget::new());
    let page = Page {
        socket,
        hub,
        visit,
        answers,
        pictures,
        budget,
        is_ready: true,
        sent: None,
        sent_at: Instant::now(),
        bad: 0,
    };
    let Left = page.serve(mail).await;
}

struct Page {
    socket: WebSocket,
    hub: Arc<Hub>,
    visit: Visit,
    answers: mpsc::Sender<Answer>,
    pictures: watch::Receiver<Option<Arc<Picture>>>,
    budget: Budget,
    /// Whether the page has drawn the last picture.
    is_ready: bool,
    /// The last picture, and its layer.
    sent: Option<(Arc<Picture>, u32)>,
    /// When it was sent.
    sent_at: Instant,
    bad: u32,
}

impl Page {
    async fn serve(mut self, mut mail: mpsc::Receiver<Answer>) -> Left {
        let hub = Arc::clone(&self.hub);
        let mut boards = [&hub.scene, &hub.setup, &hub.status].map(watch::Sender::subscribe);
        for board in &mut boards {
            board.mark_changed();
        }
        self.pictures.mark_changed();
        loop {
            let [scene, setup, status] = &mut boards;
            let served = tokio::select! {
                message = self.socket.recv(), if self.budget.is_left() => self.read(message).await,
                () = sleep(self.budget.wait()), if !self.budget.is_left() => Ok(()),
                Some(answer) = mail.recv() => self.tell(&answer).await,
                Ok(()) = scene.changed() => self.post(scene).await,
                Ok(()) = setup.changed() => self.post(setup).await,
                Ok(()) = status.changed() => self.post(status).await,
                Ok(()) = self.pictures.changed(), if self.is_ready => self.show().await,
            };
            if served.is_err() {
                return Left;
            }
        }
    }

    async fn read(&mut self, message: Option<Result<Message, axum::Error>>) -> Result<(), Left> {
        let Some(Ok(message)) = message else { return Err(Left) };
        self.budget.spend();
        let request = match &message {
            Message::Text(text) => serde_json::from_str(text.as_str()).ok(),
            Message::Ping(_) | Message::Pong(_) => return Ok(()),
            Message::Close(_) => return Err(Left),
            Message::Binary(_) => None,
        };
        match request {
            Some(Request::Ack) => {
                self.is_ready = true;
                if let Some((picture, _)) = &self.sent {
                    self.hub.note_drawn(picture, self.sent_at.elapsed());
                }
                Ok(())
            }
            Some(Request::Layer { layer }) if (layer as usize) < MAX_LAYERS => {
                self.visit.look_at(layer as usize);
                // It may be in the last picture already.
                self.pictures.mark_changed();
                Ok(())
            }
            Some(request) if self.hub.takes_requests => self.ask(request).await,
            Some(_) => self.tell(&refused("nothing can be changed here")).await,
            None => self.refuse().await,
        }
    }

    /// Passes on a request, as soon as there is room for it.
    async fn ask(&mut self, request: Request) -> Result<(), Left> {
        let mut asked = Asked::new(request, self.answers.clone());
        while let Err(back) = self.hub.requests.leave(asked) {
            asked = back;
            sleep(BUSY).await;
        }
        Ok(())
    }

    async fn refuse(&mut self) -> Result<(), Left> {
        self.bad += 1;
        if self.bad <= MAX_BAD {
            return self.tell(&refused("that request is unknown")).await;
        }
        let reason = "too many unknown requests".into();
        let _ = self.send(Message::Close(Some(CloseFrame { code: POLICY, reason }))).await;
        Err(Left)
    }

    async fn show(&mut self) -> Result<(), Left> {
        let picture = self.pictures.borrow_and_update().clone();
        let Some(picture) = picture else { return Ok(()) };
        let layer = self.visit.layer();
        let is_sent = |(sent, of): &(Arc<Picture>, u32)| Arc::ptr_eq(sent, &picture) && *of == layer;
        // A layer that it lacks comes with the next picture, which is on its way.
        let Some(bytes) = picture.layer(layer).filter(|_| !self.sent.as_ref().is_some_and(is_sent)) else {
            return Ok(());
        };
        (self.is_ready, self.sent, self.sent_at) = (false, Some((picture, layer)), Instant::now());
        self.send(Message::Binary(bytes)).await
    }

    async fn post(&mut self, board: &mut watch::Receiver<Arc<str>>) -> Result<(), Left> {
        let text = Arc::clone(&board.borrow_and_update());
        if text.is_empty() { Ok(()) } else { self.send(Message::Text((*text).into())).await }
    }

    async fn tell(&mut self, answer: &impl Serialize) -> Result<(), Left> {
        let text = serde_json::to_string(answer).map_err(|_| Left)?;
        self.send(Message::Text(text.into())).await
    }

    async fn send(&mut self, message: Message) -> Result<(), Left> {
        match timeout(PATIENCE, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            _ => Err(Left),
        }
    }
}

fn refused(problem: &str) -> Answer {
    Answer::Refused { problem: problem.into() }
}

/// How many messages may still be read.
struct Budget {
    left: f64,
    at: Instant,
}

impl Budget {
    fn new() -> Self {
        Self { left: BURST, at: Instant::now() }
    }

    fn is_left(&mut self) -> bool {
        let now = Instant::now();
        self.left = (self.left + RATE * (now - self.at).as_secs_f64()).min(BURST);
        self.at = now;
        self.left >= 1.0
    }

    fn spend(&mut self) {
        self.left -= 1.0;
    }

    /// The time until one more may be read.
    fn wait(&self) -> Duration {
        Duration::from_secs_f64(((1.0 - self.left) / RATE).max(1e-3))
    }
}
