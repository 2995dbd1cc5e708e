//! GRO files.

use super::{fault, parse};
use importers::{Format, Unit};
use std::fmt::Write as _;

#[test]
fn numbers_of_gro_files_go_on_beyond_five_digits() {
    let mut text = String::from("many\n100003\n");
    for at in 0..100_003 {
        let number = (at + 99_999) % 100_000;
        let _ = writeln!(text, "{number:>5}ION     NA{number:>5}   1.000   2.000   3.000");
    }
    text.push_str("4 5 6\n");
    let particles = parse(Format::Gro, &text);
    assert_eq!(particles.ids.as_ref().unwrap()[..3], [99_999, 100_000, 100_001]);
    assert_eq!(particles.ids.unwrap()[100_002], 200_001);
    assert_eq!(particles.residue_numbers.unwrap()[100_002], 200_001);
    assert_eq!((particles.unit, particles.cell.unwrap().vectors[2]), (Unit::Nanometre, [0.0, 0.0, 6.0]));
    // What is not in order, such as a selection, has not come to the end of its digits.
    let row = |number: u32| format!("{number:>5}ION     NA{number:>5}   1.000   2.000   3.000\n");
    let text = ["few\n4\n", &row(70), &row(3), &row(40_000), &row(12), "4 5 6\n"].concat();
    let particles = parse(Format::Gro, text);
    assert_eq!(particles.ids, Some(vec![70, 3, 40_000, 12]));
    assert_eq!(particles.residue_numbers, Some(vec![70, 3, 40_000, 12]));
    // Stars and blanks stand for no number.
    let place = "   1.000   2.000   3.000\n";
    let text = format!(
        "a\n3\n    8ION     NA    7{place}     ION     NA     {place}*****ION     NA*****{place}4 5 6\n"
    );
    let particles = parse(Format::Gro, text);
    assert_eq!((particles.ids, particles.residue_numbers), (Some(vec![7, 0, 0]), Some(vec![8, 0, 0])));
    // More decimals make columns wider.
    let wide = "wide\n1\n    1SOL     OW    1    0.123456    1.234567   12.345678\n 1 2 3\n";
    assert_eq!(parse(Format::Gro, wide).positions, [[0.123_456, 1.234_567, 12.345_678]]);
    assert!(
        fault(Format::Gro, "a\n1\n    1SOL     OW    1   0.126   1.x   0.679\n1 1 1\n")
            .starts_with(":3:29: \"1.x\" is no number")
    );
    assert!(
        fault(Format::Gro, "a\n1\n    1SOL     OW\n1 1 1\n").starts_with(":3:16: the line has 15 columns")
    );
    assert!(fault(Format::Gro, "a\nb\n").starts_with(":2: \"b\" is no number of atoms"));
}
