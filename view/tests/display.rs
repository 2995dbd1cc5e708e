//! The stream to tev, read by a viewer that takes it apart as the specification says.

use scene::{Film, Rgb};
use std::io::{self, Read};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};
use view::Display;

/// What takes longer is taken to be lost.
const PATIENCE: Duration = Duration::from_secs(30);

/// A packet, read field by field.
#[derive(Debug, PartialEq)]
enum Packet {
    Create { grab: bool, name: String, size: [u32; 2], channels: Vec<String> },
    Update { grab: bool, name: String, channels: Vec<String>, tile: [u32; 4], pixels: Vec<[f32; 3]> },
}

/// The fields of a packet, in order.
struct Fields(Vec<u8>);

impl Fields {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.0.drain(..N).collect::<Vec<u8>>().try_into().unwrap()
    }

    fn bool(&mut self) -> bool {
        let [byte] = self.take();
        assert!(byte <= 1, "{byte} is no truth value");
        byte == 1
    }

    fn i32(&mut self) -> u32 {
        u32::try_from(i32::from_le_bytes(self.take())).unwrap()
    }

    fn i64(&mut self) -> usize {
        usize::try_from(i64::from_le_bytes(self.take())).unwrap()
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).unwrap();
        let text = String::from_utf8(self.0.drain(..end).collect()).unwrap();
        self.take::<1>();
        text
    }
}

/// Reads a packet; `None` at the end.
fn read(stream: &mut TcpStream) -> Option<Packet> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).ok()?;
    let mut rest = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut rest).ok()?;
    let mut fields = Fields(rest);
    let [kind] = fields.take();
    let (grab, name) = (fields.bool(), fields.text());
    let packet = match kind {
        4 => {
            let size = [fields.i32(), fields.i32()];
            let channels = (0..fields.i32()).map(|_| fields.text()).collect();
            Packet::Create { grab, name, size, channels }
        }
        6 => {
            let count = fields.i32() as usize;
            let channels: Vec<String> = (0..count).map(|_| fields.text()).collect();
            let tile = [0; 4].map(|_| fields.i32());
            let offsets: Vec<usize> = (0..count).map(|_| fields.i64()).collect();
            let strides: Vec<usize> = (0..count).map(|_| fields.i64()).collect();
            let pixels = (tile[2] * tile[3]) as usize;
            let most =
                offsets.iter().zip(&strides).map(|(offset, stride)| offset + (pixels - 1) * stride + 1);
            let values: Vec<f32> =
                (0..most.max().unwrap()).map(|_| f32::from_le_bytes(fields.take())).collect();
            let value = |pixel: usize, channel: usize| values[offsets[channel] + pixel * strides[channel]];
            let pixels = (0..pixels).map(|pixel| [0, 1, 2].map(|channel| value(pixel, channel))).collect();
            Packet::Update { grab, name, channels, tile, pixels }
        }
        kind => panic!("type {kind}"),
    };
    assert!(fields.0.is_empty(), "{} bytes too many", fields.0.len());
    Some(packet)
}

/// A viewer, and the image that it shows.
struct Viewer {
    stream: TcpStream,
    film: Option<Film>,
    /// The tiles that came since they were last counted.
    tiles: Vec<[u32; 4]>,
}

impl Viewer {
    fn accept(listener: &TcpListener) -> Self {
        listener.set_nonblocking(true).unwrap();
        let until = Instant::now() + PATIENCE;
        loop {
            match listener.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(false).unwrap();
                    stream.set_read_timeout(Some(PATIENCE)).unwrap();
                    return Self { stream, film: None, tiles: Vec::new() };
                }
                Err(error) => {
                    assert!(error.kind() == io::ErrorKind::WouldBlock && Instant::now() < until, "{error}");
                }
            }
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// Reads until it shows `film`.
    fn wait_for(&mut self, film: &Film) {
        while self.film.as_ref() != Some(film) {
            match read(&mut self.stream).expect("more comes") {
                Packet::Create { grab, name, size: [width, height], channels } => {
                    assert!(grab);
                    assert_eq!(
                        (name.as_str(), channels),
                        ("box", ["R", "G", "B"].map(String::from).to_vec())
                    );
                    self.film = Some(Film::new(width, height));
                }
                Packet::Update { grab, name, channels, tile, pixels } => {
                    assert!(!grab);
                    assert_eq!((name.as_str(), channels.len()), ("box", 3));
                    self.tiles.push(tile);
                    let film = self.film.as_mut().expect("an image is created before it is changed");
                    let [x, y, width, _] = tile;
                    for (i, pixel) in pixels.into_iter().enumerate() {
                        let at = (y + i as u32 / width) * film.width + x + i as u32 % width;
                        film.pixels[at as usize] = Rgb::from(pixel);
                    }
                }
            }
        }
    }
}

/// Shows an image once the last one is sent.
fn show(display: &Display, film: &Film) {
    let until = Instant::now() + PATIENCE;
    while !display.is_due() {
        assert!(Instant::now() < until, "the last image is never sent");
        thread::sleep(Duration::from_millis(5));
    }
    display.show(film.clone());
}

fn film() -> Film {
    Film::from_fn(300, 200, |x, y| Rgb::new(x as f32, y as f32, 0.1))
}

#[test]
fn only_tiles_that_changed_are_sent_and_all_of_them_to_a_new_viewer() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap();
    let display = Display::new(place.to_string(), "box".into()).unwrap();
    let mut now = film();
    show(&display, &now);
    let mut viewer = Viewer::accept(&listener);
    viewer.wait_for(&now);
    let all = [
        [0, 0, 128, 128],
        [128, 0, 128, 128],
        [256, 0, 44, 128],
        [0, 128, 128, 72],
        [128, 128, 128, 72],
        [256, 128, 44, 72],
    ];
    assert_eq!(viewer.tiles, all);
    // The last pixel of the first tile, and one of the last.
    viewer.tiles.clear();
    now.pixels[127 * 300 + 127].x = -1.0;
    now.pixels[199 * 300 + 299].y = f32::INFINITY;
    show(&display, &now);
    viewer.wait_for(&now);
    assert_eq!(viewer.tiles, [[0, 0, 128, 128], [256, 128, 44, 72]]);
    // The viewer is killed, and another one comes.
    drop(viewer);
    now.pixels[0].x = 5.0;
    show(&display, &now);
    let mut viewer = Viewer::accept(&listener);
    viewer.wait_for(&now);
    assert_eq!(viewer.tiles, all);
}

/// As many pixels in other rows are another image.
#[test]
fn an_image_of_another_shape_is_created_anew() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let display = Display::new(listener.local_addr().unwrap().to_string(), "box".into()).unwrap();
    let wide = film();
    show(&display, &wide);
    let mut viewer = Viewer::accept(&listener);
    viewer.wait_for(&wide);
    let high = Film { width: wide.height, height: wide.width, pixels: wide.pixels };
    show(&display, &high);
    viewer.wait_for(&high);
}

#[test]
fn a_viewer_that_comes_late_gets_the_newest_image_and_nobody_waits_for_it() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap();
    drop(listener);
    let display = Display::new(place.to_string(), "box".into()).unwrap();
    let mut now = film();
    for i in 0..1000_u16 {
        now.pixels[7].x = i.into();
        display.show(now.clone());
    }
    let listener = TcpListener::bind(place).unwrap();
    Viewer::accept(&listener).wait_for(&now);
}

/// A viewer that never reads.
#[test]
fn a_viewer_that_does_not_read_holds_up_nobody() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let display = Display::new(listener.local_addr().unwrap().to_string(), "box".into()).unwrap();
    let large = Film::from_fn(2000, 2000, |x, y| Rgb::new(x as f32, y as f32, 1.0));
    display.show(large);
    let _viewer = Viewer::accept(&listener);
    let mut shown = 0;
    for _ in 0..20 {
        if display.is_due() {
            display.show(film());
            shown += 1;
        }
    }
    assert_eq!(shown, 0, "no image is welcome while one is being sent");
}

#[test]
fn the_last_image_is_sent_when_the_render_is_over() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let display = Display::new(listener.local_addr().unwrap().to_string(), "box".into()).unwrap();
    let viewer = thread::spawn(move || Viewer::accept(&listener).wait_for(&film()));
    display.show(film());
    drop(display);
    viewer.join().unwrap();
}

/// It is looked for several times meanwhile.
#[test]
fn a_viewer_that_is_not_there_is_told_once() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap();
    drop(listener);
    let (sender, told) = mpsc::channel();
    let tell = move |problem: &str| sender.send(problem.to_owned()).unwrap();
    let display = Display::telling(place.to_string(), "box".into(), tell).unwrap();
    display.show(film());
    let line = told.recv_timeout(PATIENCE).unwrap();
    assert!(line.contains(&place.to_string()) && line.contains("looked for"), "{line}");
    thread::sleep(Duration::from_millis(1200));
    assert!(told.try_recv().is_err(), "it is told again");
    let listener = TcpListener::bind(place).unwrap();
    Viewer::accept(&listener).wait_for(&film());
}

/// Each time that it is gone is told, once.
#[test]
fn a_viewer_that_came_and_is_gone_again_is_told_once_more() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap();
    let (sender, told) = mpsc::channel();
    let tell = move |problem: &str| sender.send(problem.to_owned()).unwrap();
    let display = Display::telling(place.to_string(), "box".into(), tell).unwrap();
    // So small that it is sent before the viewer reads it.
    let mut now = Film::new(8, 8);
    show(&display, &now);
    for round in 0..2 {
        let mut viewer = Viewer::accept(&listener);
        viewer.wait_for(&now);
        assert!(told.try_recv().is_err(), "round {round}: it is there");
        drop(viewer);
        // What is sent before the system tells that nobody reads is lost; then another image is needed.
        let until = Instant::now() + PATIENCE;
        let line = loop {
            now.pixels[0].x += 1.0;
            show(&display, &now);
            if let Ok(line) = told.recv_timeout(Duration::from_millis(20)) {
                break line;
            }
            assert!(Instant::now() < until, "round {round}: it is not told");
        };
        assert!(line.contains(&place.to_string()), "{line}");
    }
}
