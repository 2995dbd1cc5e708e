//! The memory that reading a scene takes, by what its text looks like.

use super::pieces::{Kind, MOST_BYTES as MOST_PIECE_BYTES, Pieces};
use crate::particles::BYTES_PER_PARTICLE;
use scene::Sphere;
use scene::text::mebibytes;

/// Memory per sphere while a scene is read, beside the text: in the scene; 42 were measured, and 62, 86 and 247 with what
/// follows.
const BYTES_PER_SPHERE: u64 = 48;
/// The same in a scene in which something may move, in addition: where the sphere is at one instant.
const BYTES_PER_MOVED_SPHERE: u64 = 48;
/// The same per sphere with a material of its own, in addition.
const BYTES_PER_OWN_MATERIAL: u64 = 28;
/// The same per lamp, in addition: what is found out about its light.
const BYTES_PER_LAMP: u64 = 224;
/// The same per material with a name.
const BYTES_PER_MATERIAL: u64 = 192;
/// Memory per byte of the head, which is parsed at once.
const BYTES_PER_HEAD_BYTE: u64 = 48;

/// The number of spheres, and a bound of the memory that reading them and the rest takes, the text included. Of a sphere, the
/// words tell what it may be.
pub(super) fn measure(text: &str) -> (u64, u64) {
    let (mut spheres, mut head, mut bytes) = (0, 0, text.len() as u64);
    let mut moves = false;
    for piece in Pieces::new(text) {
        let piece_text = &text[piece.span.clone()];
        match piece.kind {
            Kind::Sphere => {
                spheres += 1;
                // Letters of a word may be escaped.
                let may = |word: &str| piece_text.contains(word) || piece_text.contains('\\');
                // A material in braces, or in a table of its own.
                let has_own = may("{") || may("sphere.");
                bytes += BYTES_PER_SPHERE;
                bytes += if has_own { BYTES_PER_OWN_MATERIAL } else { 0 };
                bytes += if may("emission") { BYTES_PER_LAMP } else { 0 };
                moves |= may("velocity");
            }
            Kind::Material => bytes += BYTES_PER_MATERIAL,
            Kind::Head => head += piece_text.len() as u64,
        }
    }
    let of_moved = if moves { BYTES_PER_MOVED_SPHERE * spheres } else { 0 };
    (spheres, bytes + of_moved + BYTES_PER_HEAD_BYTE * head.min(MOST_PIECE_BYTES as u64))
}

/// A bound of the memory that reading files of particles took, of which these spheres were made.
pub(super) fn of_imported(spheres: &[Sphere]) -> u64 {
    let lamps = spheres.iter().filter(|sphere| sphere.is_emitter()).count() as u64;
    BYTES_PER_PARTICLE * spheres.len() as u64 + BYTES_PER_LAMP * lamps
}

/// What is wrong with a scene that takes so many `bytes` to read where `most` are allowed.
pub(super) fn too_much(bytes: u64, most: u64) -> String {
    format!("takes up to {} to read, more than the limit of {}", mebibytes(bytes), mebibytes(most))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::load_within;

    const HEAD: &str = "[camera]\neye = [0, 0, 9]\n";
    const PLAIN: &str = "[[sphere]]\nradius = 1\nmaterial = \"a\"\n";

    fn bytes(text: &str) -> u64 {
        measure(text).1 - text.len() as u64
    }

    #[test]
    fn each_piece_takes_its_own_bytes() {
        let head = bytes(HEAD);
        assert_eq!(head, BYTES_PER_HEAD_BYTE * HEAD.len() as u64);
        let with = |pieces: &[&str]| bytes(&[&[HEAD], pieces].concat().concat()) - head;
        assert_eq!(measure(&[HEAD, PLAIN, PLAIN].concat()).0, 2);
        assert_eq!(with(&[PLAIN, PLAIN, PLAIN]), 3 * BYTES_PER_SPHERE);
        let lamp = "[[sphere]]\nemission = [1, 1, 1]\n";
        assert_eq!(with(&[PLAIN, lamp]), 2 * BYTES_PER_SPHERE + BYTES_PER_LAMP);
        let own = "[[sphere]]\nmaterial = { type = \"diffuse\" }\n";
        assert_eq!(with(&[PLAIN, own]), 2 * BYTES_PER_SPHERE + BYTES_PER_OWN_MATERIAL);
        let material = "[materials.a]\ntype = \"diffuse\"\n";
        assert_eq!(with(&[PLAIN, material]), BYTES_PER_SPHERE + BYTES_PER_MATERIAL);
        // If one sphere moves, there is another list of all.
        let moving = "[[sphere]]\nvelocity = [1, 0, 0]\n";
        assert_eq!(with(&[PLAIN, PLAIN, moving]), 3 * (BYTES_PER_SPHERE + BYTES_PER_MOVED_SPHERE));
    }

    #[test]
    fn a_word_that_is_escaped_may_be_any() {
        let escaped = "[[sphere]]\n\"\\u0065mission\" = [1, 1, 1]\n";
        let all = BYTES_PER_SPHERE + BYTES_PER_OWN_MATERIAL + BYTES_PER_LAMP + BYTES_PER_MOVED_SPHERE;
        assert_eq!(bytes(escaped), all);
    }

    #[test]
    fn what_is_too_much_is_told_with_the_limit() {
        assert_eq!(too_much(3 << 20, 1 << 20), "takes up to 3.0 MiB to read, more than the limit of 1.0 MiB");
    }

    /// They may take what the text leaves of what is allowed, and count with it.
    #[test]
    fn files_of_particles_share_the_memory_with_the_text() {
        let folder = tempfile::tempdir().unwrap();
        let [path, atoms] = ["a.toml", "a.xyz"].map(|name| folder.path().join(name));
        let text = format!(
            "{}\nbackground = [1, 1, 1]\n[camera]\neye = [0, 9, 0]\ntarget = [1, 0, 0]\nvertical_fov_degrees = 40\n\
             [[particles]]\nfile = \"a.xyz\"\n",
            "#".repeat(1 << 13)
        );
        std::fs::write(&path, &text).unwrap();
        let (_, of_text) = measure(&text);
        let bytes = |count: usize, most: u64| {
            let row = |i| format!("C {} 0 0\n", 4 * i);
            let rows: String = (0..count).map(row).collect();
            std::fs::write(&atoms, format!("{count}\n\n{rows}")).unwrap();
            load_within(&path, [None; 2], most).map(|loaded| loaded.bytes).map_err(|error| error.to_string())
        };
        let [few, many] = [1000, 2000].map(|count| bytes(count, u64::MAX).unwrap());
        assert!(few >= of_text + 1000 * BYTES_PER_PARTICLE, "{few}");
        assert_eq!(many, few + 1000 * BYTES_PER_PARTICLE);
        let problem = bytes(1000, of_text + 1000).unwrap_err();
        assert!(
            problem.contains("1000 particles need") && problem.contains("allow more memory"),
            "{problem}"
        );
    }

    #[test]
    fn particles_take_their_bytes_and_lamps_more() {
        let scene = crate::builtin::scene("cornell").unwrap();
        let lamp = *scene.spheres.iter().find(|sphere| sphere.is_emitter()).unwrap();
        let dark = *scene.spheres.iter().find(|sphere| !sphere.is_emitter()).unwrap();
        assert_eq!(of_imported(&[]), 0);
        assert_eq!(of_imported(&[dark; 5]), 5 * BYTES_PER_PARTICLE);
        assert_eq!(of_imported(&[dark, lamp, dark, lamp]), 4 * BYTES_PER_PARTICLE + 2 * BYTES_PER_LAMP);
    }
}
