//! The image formats, and how a file's is recognised: by its content when it is read, by its name when it is written.

use super::ImageError;
use std::path::Path;

/// An image format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.png`: sRGB.
    Png,
    /// `.jpg`: 8 bits of sRGB, lossy.
    Jpeg,
    /// `.exr`: linear.
    Exr,
    /// `.pfm`: linear `f32`.
    Pfm,
    /// `.hdr`, Radiance: linear, 8 bits per channel with a common exponent.
    Hdr,
    /// `.tif`: linear `f32` where it is written; sRGB if it holds integers.
    Tiff,
    /// `.webp`: 8 bits of sRGB. Is read only.
    WebP,
    /// `.qoi`: 8 bits of sRGB. Is read only.
    Qoi,
}

/// The extensions of what can be written, for messages.
const WRITTEN: &str = ".png, .jpg, .exr, .pfm, .hdr or .tif";

/// The bytes at the beginning of a file that tell its format.
const BEGINNINGS: [(&[u8], Format); 10] = [
    (b"\x89PNG", Format::Png),
    (b"\xff\xd8\xff", Format::Jpeg),
    (b"\x76\x2f\x31\x01", Format::Exr),
    (b"PF", Format::Pfm),
    (b"Pf", Format::Pfm),
    (b"#?RADIANCE", Format::Hdr),
    (b"#?RGBE", Format::Hdr),
    (b"II*\0", Format::Tiff),
    (b"MM\0*", Format::Tiff),
    (b"qoif", Format::Qoi),
];

impl Format {
    /// The format to write to the file `path`, by its extension in upper or lower case.
    ///
    /// # Errors
    /// If the extension is not one of those that can be written.
    pub fn from_path(path: &Path) -> Result<Self, ImageError> {
        let refused = |has: String| Err(ImageError::new(path, format!("{has}; it must be {WRITTEN}")));
        match Self::of_extension(path) {
            Some(format) if format.is_written() => Ok(format),
            Some(format) => refused(format!("would be {}, which can be read but not written", format.name())),
            None => match extension(path).as_str() {
                "" => refused("has no extension".into()),
                other => refused(format!("has the extension .{}", other.escape_debug())),
            },
        }
    }

    /// The format that the extension of `path` names, of all that can be read.
    pub(super) fn of_extension(path: &Path) -> Option<Self> {
        Some(match extension(path).as_str() {
            "png" => Self::Png,
            "jpg" | "jpeg" => Self::Jpeg,
            "exr" => Self::Exr,
            "pfm" => Self::Pfm,
            "hdr" => Self::Hdr,
            "tif" | "tiff" => Self::Tiff,
            "webp" => Self::WebP,
            "qoi" => Self::Qoi,
            _ => return None,
        })
    }

    /// The format of a file that begins with `start`, of which 12 bytes are enough.
    pub fn of_content(start: &[u8]) -> Option<Self> {
        if start.starts_with(b"RIFF") && start.get(8..12) == Some(b"WEBP") {
            return Some(Self::WebP);
        }
        BEGINNINGS.iter().find(|(beginning, _)| start.starts_with(beginning)).map(|(_, format)| *format)
    }

    /// The usual name of the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Exr => "EXR",
            Self::Pfm => "PFM",
            Self::Hdr => "HDR",
            Self::Tiff => "TIFF",
            Self::WebP => "WebP",
            Self::Qoi => "QOI",
        }
    }

    /// Whether files of this format can be written.
    pub fn is_written(self) -> bool {
        !matches!(self, Self::WebP | Self::Qoi)
    }

    /// Whether files of this format can be written with alpha.
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::Png | Self::Exr | Self::Tiff)
    }

    /// Whether an image is exposed and encoded as sRGB when it is written. The other formats hold radiance.
    pub fn is_exposed(self) -> bool {
        matches!(self, Self::Png | Self::Jpeg)
    }
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Format; 8] = [
        Format::Png,
        Format::Jpeg,
        Format::Exr,
        Format::Pfm,
        Format::Hdr,
        Format::Tiff,
        Format::WebP,
        Format::Qoi,
    ];

    #[test]
    fn extensions_name_formats_in_either_case() {
        for (name, format) in [
            ("a.png", Format::Png),
            ("a.JPG", Format::Jpeg),
            ("a.jpeg", Format::Jpeg),
            ("a.Exr", Format::Exr),
            ("a.pfm", Format::Pfm),
            ("a.hdr", Format::Hdr),
            ("a.tif", Format::Tiff),
            ("a.TIFF", Format::Tiff),
        ] {
            assert_eq!(Format::from_path(Path::new(name)).unwrap(), format);
        }
        let problem = |name: &str| Format::from_path(Path::new(name)).unwrap_err().to_string();
        assert_eq!(
            problem("a.webp"),
            format!("a.webp: would be WebP, which can be read but not written; it must be {WRITTEN}")
        );
        assert_eq!(
            problem("a.qoi"),
            format!("a.qoi: would be QOI, which can be read but not written; it must be {WRITTEN}")
        );
        assert_eq!(problem("a"), format!("a: has no extension; it must be {WRITTEN}"));
        assert_eq!(problem("a.Txt"), format!("a.Txt: has the extension .txt; it must be {WRITTEN}"));
        // Each has its own, and what can be written is what the message says.
        for format in ALL {
            let name = format!("a.{}", format.name().to_lowercase());
            assert_eq!(Format::of_extension(Path::new(&name)), Some(format));
            assert_eq!(
                WRITTEN.contains(&format!(".{}", &format.name().to_lowercase()[..3])),
                format.is_written() && format != Format::Jpeg
            );
        }
    }

    #[test]
    fn content_tells_the_format() {
        for (start, format) in [
            (&b"\x89PNG\r\n\x1a\n"[..], Some(Format::Png)),
            (b"\xff\xd8\xff\xe0", Some(Format::Jpeg)),
            (b"\x76\x2f\x31\x01", Some(Format::Exr)),
            (b"PF\n", Some(Format::Pfm)),
            (b"Pf\n", Some(Format::Pfm)),
            (b"#?RADIANCE\n", Some(Format::Hdr)),
            (b"#?RGBE\n", Some(Format::Hdr)),
            (b"II*\0", Some(Format::Tiff)),
            (b"MM\0*", Some(Format::Tiff)),
            (b"qoif", Some(Format::Qoi)),
            (b"RIFF1234WEBP", Some(Format::WebP)),
            (b"RIFF1234WAVE", None),
            (b"RIFF", None),
            (b"P6\n", None),
            (b"", None),
        ] {
            assert_eq!(Format::of_content(start), format, "{start:?}");
        }
    }

    #[test]
    fn formats_hold_what_they_can() {
        let with =
            |has: fn(Format) -> bool| ALL.into_iter().filter(|format| has(*format)).collect::<Vec<_>>();
        assert_eq!(with(Format::has_alpha), [Format::Png, Format::Exr, Format::Tiff]);
        assert_eq!(with(Format::is_exposed), [Format::Png, Format::Jpeg]);
        assert_eq!(with(|format| !format.is_written()), [Format::WebP, Format::Qoi]);
    }
}
