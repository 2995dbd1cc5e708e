//! The web server: the page, its websocket, and downloads. One thread.

use crate::client::{self, MAX_MESSAGE};
use crate::gate::{self, Refusal};
use crate::hub::Hub;
use crate::kept::Look;
use crate::listener::Limited;
use crate::page;
use crate::place::Place;
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Path, RawQuery, Request, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_TYPE, HeaderName, HeaderValue};
use axum::http::{Method, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use files::atomic_file::reason;
use files::image_file::{Tone, USUAL_WHITE};
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use tokio::runtime::Builder;
use tokio::sync::oneshot;

/// More pages are turned away.
const MAX_CLIENTS: usize = 128;

/// Bytes that a connection buffers, beside the picture that is being sent.
const BUFFER: usize = 1 << 13;

/// On every answer. The page is alone in its frame and loads nothing from elsewhere; its address, with the token, is told to
/// nobody.
const HEADERS: [(&str, &str); 7] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("permissions-policy", "camera=(), microphone=(), geolocation=()"),
];

/// A running server. Dropping it ends it.
#[derive(Debug)]
pub(crate) struct Server {
    /// The address of the page, with its token.
    pub(crate) address: String,
    quit: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    hub: Arc<Hub>,
    token: String,
}

impl Server {
    /// Listens at this place.
    ///
    /// # Errors
    /// If the port is taken, or if the token is too short, if the system denies something.
    pub(crate) fn start(hub: Arc<Hub>, place: &Place) -> Result<Self, String> {
        let token = place.token.as_deref().map_or_else(gate::new_token, gate::given_token)?;
        let ip = place.ip;
        let place = SocketAddr::new(ip, place.port);
        let failed = |error: &io::Error| format!("cannot listen at {place}: {}", reason(error));
        let listener = TcpListener::bind(place).map_err(|error| failed(&error))?;
        let bound = listener.local_addr().map_err(|error| failed(&error))?;
        listener.set_nonblocking(true).map_err(|error| failed(&error))?;
        let runtime = Builder::new_current_thread().enable_all().build().map_err(|error| failed(&error))?;
        // Nobody can open 0.0.0.0; the loopback address leads there too.
        let shown =
            if ip.is_unspecified() { SocketAddr::new([127, 0, 0, 1].into(), bound.port()) } else { bound };
        let address = format!("http://{shown}/{token}/");
        let (quit, ended) = oneshot::channel();
        let app = routes(Arc::new(Shared { hub, token }));
        let serve = async move {
            let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
            tokio::select! {
                _ = axum::serve(Limited::new(listener), app) => {}
                _ = ended => {}
            }
        };
        let begun = thread::Builder::new().name("view".into()).spawn(move || {
            runtime.block_on(serve);
            runtime.shutdown_background();
        });
        let thread = begun.map_err(|error| failed(&error))?;
        Ok(Self { address, quit: Some(quit), thread: Some(thread) })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.quit.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // there is nobody to tell that it panicked
        }
    }
}

fn routes(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/{token}/", get(|| async { file("index.html") }))
        .route("/{token}/{name}", get(|Path((_, name)): Path<(String, String)>| async move { file(&name) }))
        .route("/{token}/socket", get(socket))
        .route("/{token}/other/{number}", get(other))
        .route("/{token}/save/{number}/{name}", get(save))
        .fallback(|| async { missing() })
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), guard))
        .with_state(shared)
}

/// Lets in only who knows the token and comes from the page itself.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let given = request.uri().path().split('/').nth(1).unwrap_or_default();
    let mut response = match gate::check(request.headers(), given, &shared.token) {
        Err(refusal) => refused(refusal),
        Ok(()) if *request.method() != Method::GET => StatusCode::METHOD_NOT_ALLOWED.into_response(),
        Ok(()) => next.run(request).await,
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}

fn refused(refusal: Refusal) -> Response {
    (StatusCode::FORBIDDEN, refusal.text()).into_response()
}

fn missing() -> Response {
    (StatusCode::NOT_FOUND, "There is nothing here.\n").into_response()
}

fn file(name: &str) -> Response {
    match page::file(name) {
        Some((text, kind)) => ([(CONTENT_TYPE, kind)], text).into_response(),
        None => missing(),
    }
}

async fn socket(State(shared): State<Arc<Shared>>, upgrade: WebSocketUpgrade) -> Response {
    let hub = Arc::clone(&shared.hub);
    match hub.enter(MAX_CLIENTS) {
        None => (StatusCode::SERVICE_UNAVAILABLE, "Too many pages are open.\n").into_response(),
        Some(visit) => upgrade
            .max_message_size(MAX_MESSAGE)
            .max_frame_size(MAX_MESSAGE)
            .read_buffer_size(BUFFER)
            .write_buffer_size(BUFFER)
            .on_upgrade(move |socket| client::serve(socket, hub, visit)),
    }
}

/// An image to compare with.
async fn other(State(shared): State<Arc<Shared>>, Path((_, number)): Path<(String, usize)>) -> Response {
    match shared.hub.others.get(number) {
        Some((_, bytes)) => bytes.clone().into_response(),
        None => missing(),
    }
}

/// How a PNG is to look, by a query such as `exposure=1&tone=aces`. What is not given, or means nothing, is as usual.
fn look(query: &str) -> Look {
    let values = |name: &str| query.split('&').find_map(|pair| pair.strip_prefix(name)?.strip_prefix('='));
    let number = |name| values(name).and_then(|value| value.parse::<f32>().ok()).filter(|v| v.is_finite());
    let white = number("white").filter(|white| *white > 0.0).unwrap_or(USUAL_WHITE);
    let tone = values("tone").and_then(|name| Tone::named(name, white)).unwrap_or_default();
    Look { exposure: number("exposure").unwrap_or(0.0).clamp(-100.0, 100.0), tone }
}

async fn save(
    State(shared): State<Arc<Shared>>,
    Path((_, number, name)): Path<(String, u32, String)>,
    RawQuery(query): RawQuery,
) -> Response {
    let Some(kept) = shared.hub.kept(number) else { return missing() };
    let look = look(&query.unwrap_or_default());
    // Files take long to make: other pages are served meanwhile.
    let made = tokio::task::spawn_blocking(move || kept.file(&name, look)).await;
    match made {
        Ok(Some(Ok(download))) => {
            let name = format!("attachment; filename=\"{}\"", plain(&download.name));
            let headers = [(CONTENT_TYPE, download.kind.to_owned()), (CONTENT_DISPOSITION, name)];
            (headers, Body::from(Bytes::from(download.bytes))).into_response()
        }
        Ok(Some(Err(problem))) => (StatusCode::INTERNAL_SERVER_ERROR, problem + "\n").into_response(),
        _ => missing(),
    }
}

/// A file name of letters, digits and a few signs, as a header can hold.
fn plain(name: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._- ".contains(c);
    name.chars().map(|c| if is_plain(c) { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_look_is_read_from_the_query() {
        assert_eq!(look(""), Look::default());
        assert_eq!(look("exposure=1.5&tone=aces"), Look { exposure: 1.5, tone: Tone::Aces });
        let tone = Tone::Reinhard { white: 9.0 };
        assert_eq!(look("tone=reinhard&white=9"), Look { exposure: 0.0, tone });
        assert_eq!(look("exposure=NaN&tone=x&white=-1&more"), Look::default());
        // Beyond them all is black or white.
        for (asked, exposure) in [("500", 100.0), ("-1e9", -100.0), ("99.5", 99.5)] {
            assert_eq!(look(&format!("exposure={asked}")).exposure, exposure, "{asked}");
        }
    }

    #[test]
    fn names_of_files_fit_a_header() {
        assert_eq!(plain("a b-c_d.png"), "a b-c_d.png");
        assert_eq!(plain("\"é\r\n;.exr"), "_____.exr");
    }
}
