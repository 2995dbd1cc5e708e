//! GSD files.

use super::{SINGLE, all, fault, labels, parse};
use crate::specimens::{COUNT, Chunk, gsd_of, specimens};
use importers::{Format, Frame, Particles, read_from};
use std::io::Cursor;

#[test]
fn gsd_frames_share_what_they_lack_with_the_first() {
    let specimen = specimens().into_iter().find(|specimen| specimen.format == Format::Gsd).unwrap();
    let second = read_from("a", Cursor::new(&specimen.bytes), Format::Gsd, &all(Frame::Last)).unwrap();
    assert_eq!((second.frame, second.len(), second.positions[0]), (1, COUNT, [1.0; 3]));
    assert_eq!(labels(second.types.as_ref())[..2], ["first", "other"]);
    assert_eq!((second.bonds.as_slice(), second.elements), (&[[0, 1], [2, 3]][..], None));
    assert_eq!(second.radii.unwrap()[0], 0.5, "the default diameter is 1");
    assert_eq!(second.properties[0].name, "charge");
    let cell = second.cell.unwrap();
    let middle = cell.point([0.5; 3]);
    assert!(middle.iter().all(|number| number.abs() < SINGLE), "centred at {middle:?}");
    let number = |count: u32| count.to_le_bytes().to_vec();
    // A box of two dimensions, whose height may be 0, repeats in its plane.
    for height in [0.0_f32, 3.0] {
        let bounds = [4.0, 5.0, height, 0.5, 0.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
        let cell = |dimensions: u8| {
            let chunks = [
                (0, "configuration/dimensions", 1, 1, vec![dimensions]),
                (0, "configuration/box", 9, 1, Vec::clone(&bounds)),
                (0, "particles/N", 3, 1, number(1)),
            ];
            parse(Format::Gsd, gsd_of(&chunks)).cell
        };
        assert_eq!(cell(2).unwrap().periodic, [true, true, false]);
        assert_eq!(cell(3).map(|cell| cell.periodic), (height > 0.0).then_some([true; 3]));
    }
    // Symbols are elements if all types are such.
    let typed = |names: &[u8]| {
        parse(
            Format::Gsd,
            gsd_of(&[(0, "particles/N", 3, 1, number(1)), (0, "particles/types", 5, 3, names.to_vec())]),
        )
    };
    assert_eq!(typed(b"Si\0O\0\0").elements, Some(vec![14]));
    assert_eq!(typed(b"Si\0A\0\0").elements, None);
}

/// Not with the frame before: of three frames that all say something else, whatever the last lacks is that of the first.
#[test]
fn gsd_frames_share_nothing_with_the_frame_before() {
    /// A chunk without its frame.
    type Part = (&'static str, u8, u32, Vec<u8>);
    let singles =
        |numbers: &[f32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let words = |numbers: &[u32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    // All that a frame may have; that in the middle has a particle and a bond more.
    let chunks = |frame: u8| -> Vec<Part> {
        let (of_frame, count) = (f32::from(frame), if frame == 1 { 3 } else { 2 });
        let each = |scale: f32, columns: u32| {
            let numbers = (1..=count * columns).map(|k| scale * (10.0 * of_frame + k as f32));
            singles(&numbers.collect::<Vec<_>>())
        };
        let types = ["Si\0\0O\0\0\0", "bis\0one\0", "cis\0one\0"][usize::from(frame)];
        let kinds: Vec<u32> = (0..count).map(|at| (at + u32::from(frame)) % 2).collect();
        // What joins a particle with itself is no bond.
        let bonds: &[u32] = [&[0, 1][..], &[0, 2, 1, 2], &[1, 1]][usize::from(frame)];
        let bounds = [4.0 + of_frame, 5.0 + of_frame, 6.0 + of_frame, 0.5, 0.0, 0.25];
        vec![
            ("configuration/dimensions", 1, 1, vec![if frame == 0 { 3 } else { 2 }]),
            ("configuration/box", 9, 1, singles(&bounds)),
            ("particles/N", 3, 1, words(&[count])),
            ("particles/types", 5, 4, types.into()),
            ("particles/typeid", 3, 1, words(&kinds)),
            ("particles/position", 9, 3, each(1.0, 3)),
            ("particles/diameter", 9, 1, each(0.25, 1)),
            ("particles/charge", 9, 1, each(-1.0, 1)),
            ("particles/velocity", 9, 3, each(2.0, 3)),
            ("log/particles/energy", 9, 1, each(3.0, 1)),
            ("bonds/N", 3, 1, words(&[bonds.len() as u32 / 2])),
            ("bonds/group", 3, 2, words(bonds)),
        ]
    };
    // The last of these frames.
    let read_last = |frames: &[&[Part]]| {
        let with_number = |(number, chunks): (usize, &&[Part])| {
            let chunk =
                |(name, kind, columns, bytes): &Part| (number as u64, *name, *kind, *columns, bytes.clone());
            chunks.iter().map(chunk).collect::<Vec<_>>()
        };
        let bytes = gsd_of(&frames.iter().enumerate().flat_map(with_number).collect::<Vec<_>>());
        let particles = read_from("a", Cursor::new(bytes), Format::Gsd, &all(Frame::Last)).unwrap();
        assert_eq!(particles.frame + 1, frames.len());
        Particles { frame: 0, ..particles }
    };
    let [first, middle, last] = [0, 1, 2].map(chunks);
    let step = [("configuration/step", 4, 1, 9_u64.to_le_bytes().to_vec())];
    assert_eq!(read_last(&[&first, &middle, &step]), read_last(&[&first]), "a frame that lacks all");
    assert_eq!(read_last(&[&first, &middle, &last]), read_last(&[&last]), "a frame that has all");
    for (at, lacked) in first.iter().enumerate() {
        let (mut own, mut right) = (last.clone(), last.clone());
        own.remove(at);
        right[at] = lacked.clone();
        let found = read_last(&[&first, &middle, &own]);
        assert_eq!(found, read_last(&[&right]), "a frame that lacks {}", lacked.0);
    }
    // What there is of each particle is not shared with a frame that has another number of them.
    let number = vec![middle[2].clone()];
    let is_of_all = |name: &str| !name.contains("particles/") || name == "particles/types";
    let of_all = first.iter().filter(|chunk| is_of_all(chunk.0)).chain(&number).cloned().collect::<Vec<_>>();
    let right = read_last(&[&of_all]);
    assert_eq!((&right.positions[..], right.properties.len()), (&[[0.0; 3]; 3][..], 0));
    assert_eq!(read_last(&[&first, &number]), right);
}

/// In the first version each name has 64 bytes.
#[test]
fn gsd_of_the_first_version_says_the_same() {
    let singles =
        |numbers: &[f32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let chunks = [
        (0, "particles/N", 3, 1, 2_u32.to_le_bytes().to_vec()),
        (0, "configuration/box", 9, 1, singles(&[4.0, 5.0, 6.0, 0.0, 0.5, 0.0])),
        (0, "particles/position", 9, 3, singles(&[1.0, 2.0, 3.0, -1.0, -2.0, -3.0])),
        (0, "particles/diameter", 9, 1, singles(&[0.5, 3.0])),
        (0, "particles/charge", 9, 1, singles(&[-1.0, 2.0])),
    ];
    let second = gsd_of(&chunks);
    let list_at = u64::from_le_bytes(second[24..32].try_into().unwrap()) as usize;
    let mut first = second[..list_at].to_vec();
    for (_, name, ..) in &chunks {
        let begin = first.len();
        first.extend(name.bytes());
        first.resize(begin + 64, 0);
    }
    // Room for one more.
    first.extend([0; 64]);
    first[32..40].copy_from_slice(&(chunks.len() as u64 + 1).to_le_bytes());
    first[44..48].copy_from_slice(&(1_u32 << 16).to_le_bytes());
    let particles = parse(Format::Gsd, &first);
    assert_eq!(particles.positions, [[1.0, 2.0, 3.0], [-1.0, -2.0, -3.0]]);
    assert_eq!(particles, parse(Format::Gsd, &second));
}

#[test]
fn faults_of_gsd_are_told_with_their_bytes() {
    let fault = |chunks: &[Chunk]| fault(Format::Gsd, gsd_of(chunks));
    let count = |count: u32| (0, "particles/N", 3, 1, count.to_le_bytes().to_vec());
    let nan = f32::NAN.to_le_bytes().repeat(3);
    assert!(
        fault(&[count(1), (0, "particles/position", 9, 3, nan)])
            .starts_with(": byte 260: particle 0 is at [NaN")
    );
    assert!(
        fault(&[count(2), (0, "particles/position", 9, 3, vec![0; 12])])
            .contains("is an array of 1 x 3, and should be 2 x 3")
    );
    assert!(
        fault(&[count(1), (0, "particles/typeid", 3, 1, 7_u32.to_le_bytes().to_vec())])
            .contains("particle 0 has type 7 of 1")
    );
    assert!(fault(&[count(u32::MAX)]).contains("has 4294967295 particles"));
    let bond = [0_u32, 9].into_iter().flat_map(u32::to_le_bytes).collect();
    let one = 1_u32.to_le_bytes().to_vec();
    assert!(
        fault(&[count(1), (0, "bonds/N", 3, 1, one), (0, "bonds/group", 3, 2, bond)])
            .contains("bond 0 joins 0 and 9")
    );
    assert!(fault(&[]).contains("has no frame: the file is empty"));
    assert!(super_short().starts_with(": byte 0: the header of 256 bytes is beyond the end"));
}

fn super_short() -> String {
    fault(Format::Gsd, 0x65DF_65DF_65DF_65DF_u64.to_le_bytes())
}
