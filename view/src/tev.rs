//! The protocol by which images are sent to tev, which `HDRView` understands too (tev's `Ipc.h`).
//!
//! A packet is its own length in bytes as `u32`, a type in a byte, and what belongs to it. Numbers are little-endian,
//! strings end with a zero byte, and a truth value is a byte. Nothing is answered.

/// The port that tev listens at.
pub const PORT: u16 = 14158;

const CREATE: u8 = 4;
const UPDATE: u8 = 6;
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A part of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// The left edge, in pixels.
    pub x: u32,
    /// The top edge.
    pub y: u32,
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

/// `text`, a host and perhaps a port, with tev's port unless it has one.
///
/// # Errors
/// If it is neither: `text`, and what would be right.
pub fn place(text: &str) -> Result<String, String> {
    let bad = || format!("{text}: write a host and a port, such as localhost:{PORT}");
    let (host, port) = match text.rsplit_once(':') {
        Some((host, port)) if !host.ends_with(':') && !host.is_empty() => {
            (host, port.parse().map_err(|_| bad())?)
        }
        None if !text.is_empty() => (text, PORT),
        _ => return Err(bad()),
    };
    if port == 0 { Err(bad()) } else { Ok(format!("{host}:{port}")) }
}

/// The packet that creates a black image, or replaces the one of that name.
pub fn create(name: &str, width: u32, height: u32) -> Vec<u8> {
    let mut packet = begin(CREATE, name);
    put(&mut packet, &[width, height, CHANNELS.len() as u32]);
    put_channels(&mut packet);
    finish(packet)
}

/// The packet that replaces a tile of the image `name`. `values` are red, green and blue of each pixel, row by row.
pub fn update(name: &str, tile: Tile, values: &[f32]) -> Vec<u8> {
    let mut packet = begin(UPDATE, name);
    let channels = CHANNELS.len();
    put(&mut packet, &[channels as u32]);
    put_channels(&mut packet);
    put(&mut packet, &[tile.x, tile.y, tile.width, tile.height]);
    let offsets = (0..channels as i64).flat_map(i64::to_le_bytes);
    let strides = CHANNELS.iter().flat_map(|_| (channels as i64).to_le_bytes());
    packet.extend(offsets.chain(strides));
    packet.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    finish(packet)
}

/// A packet of this type up to the name of the image. The image is not to be selected, whatever its viewer looks at.
fn begin(kind: u8, name: &str) -> Vec<u8> {
    let mut packet = vec![0, 0, 0, 0, kind, u8::from(kind == CREATE)];
    put_text(&mut packet, name);
    packet
}

fn put(packet: &mut Vec<u8>, numbers: &[u32]) {
    packet.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

fn put_text(packet: &mut Vec<u8>, text: &str) {
    packet.extend(text.bytes().filter(|byte| *byte != 0));
    packet.push(0);
}

fn put_channels(packet: &mut Vec<u8>) {
    for channel in CHANNELS {
        put_text(packet, channel);
    }
}

fn finish(mut packet: Vec<u8>) -> Vec<u8> {
    let length = (packet.len() as u32).to_le_bytes();
    packet[..4].copy_from_slice(&length);
    packet
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written out by hand from the specification.
    #[test]
    fn packets_are_as_specified_byte_for_byte() {
        let created = b"\x1f\0\0\0\x04\x01box\0\x02\0\0\0\x01\0\0\0\x03\0\0\0R\0G\0B\0";
        let mut expected = created.to_vec();
        expected[0] = created.len() as u8;
        assert_eq!(create("box", 2, 1), expected);
        let tile = Tile { x: 5, y: 6, width: 1, height: 1 };
        let mut expected =
            b"\0\0\0\0\x06\0box\0\x03\0\0\0R\0G\0B\0\x05\0\0\0\x06\0\0\0\x01\0\0\0\x01\0\0\0".to_vec();
        for number in [0_u8, 1, 2, 3, 3, 3] {
            expected.extend([number, 0, 0, 0, 0, 0, 0, 0]);
        }
        expected.extend([0, 0, 128, 63, 0, 0, 0, 64, 0, 0, 64, 64]);
        expected[0] = expected.len() as u8;
        assert_eq!(update("box", tile, &[1.0, 2.0, 3.0]), expected);
    }

    #[test]
    fn the_port_is_the_usual_one_unless_it_is_given() {
        assert_eq!(place("localhost").unwrap(), "localhost:14158");
        assert_eq!(place("10.0.0.1:99").unwrap(), "10.0.0.1:99");
        assert_eq!(place("[::1]:99").unwrap(), "[::1]:99");
        for bad in ["", ":99", "host:", "host:0", "host:65536", "host:x"] {
            assert!(place(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn no_name_ends_early() {
        assert_eq!(create("a\0b", 1, 1), create("ab", 1, 1));
    }
}
