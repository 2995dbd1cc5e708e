//! PDB files.

use super::{SINGLE, all, fault, file, labels, parse};
use crate::specimens::{COUNT, specimens};
use importers::{Format, Frame, frames, read, read_from};
use std::io::Cursor;

/// An atom of a PDB file: serial number, name, mark, residue, chain, number of the residue, and what comes after.
fn atom(serial: &str, name: &str, mark: char, residue: &str, number: &str, rest: &str) -> String {
    format!("ATOM  {serial:>5} {name:<4}{mark}{residue:>3} A{number:>4}    {rest}\n")
}

#[test]
fn pdb_numbers_go_on_in_hybrid_36() {
    let place = "   1.000   2.000   3.000  1.00  5.00";
    let mut text = [("99999", "9999"), ("A0000", "A000"), ("a0000", "a000"), ("*****", "****")]
        .map(|(serial, number)| atom(serial, " CA ", ' ', "ALA", number, place))
        .concat();
    text.push_str("CONECT99999A0000\nCONECTa0000A000099999\nCONECT    7    8\n");
    let particles = parse(Format::Pdb, &text);
    assert_eq!(particles.ids, Some(vec![99_999, 100_000, 43_770_016, 43_770_017]));
    assert_eq!(particles.residue_numbers, Some(vec![9999, 10_000, 1_223_056, 0]));
    assert_eq!(particles.bonds, [[0, 1], [0, 2], [1, 2]]);
    assert_eq!(particles.property("b_factor"), Some(&[5.0; 4][..]));
    assert_eq!((particles.elements, labels(particles.chains.as_ref())), (Some(vec![6; 4]), vec!["A"; 4]));
}

/// Programs with more atoms than five columns hold take one more: before serial numbers and after those of residues it is blank
/// otherwise.
#[test]
fn pdb_numbers_may_be_one_column_wider() {
    let row = |serial: u32, number: u32| {
        format!("ATOM  {serial:>6} CA  ALA A{number:>5}      1.000   2.000   3.000\n")
    };
    let particles = parse(Format::Pdb, [row(123_456, 12_345), row(123_457, 12_346)].concat());
    assert_eq!(particles.ids, Some(vec![123_456, 123_457]));
    assert_eq!(particles.residue_numbers, Some(vec![12_345, 12_346]));
    assert_eq!(labels(particles.names.as_ref()), ["CA", "CA"]);
}

/// The columns of the element go before the name, which tells it where they are empty or hold something else.
#[test]
fn pdb_elements_are_those_of_their_columns() {
    let row = |name: &str, residue: &str, element: &str| {
        let rest = format!("   1.000   2.000   3.000  1.00  5.00          {element:>2}");
        atom("1", name, ' ', residue, "1", &rest)
    };
    let text = [
        row(" CA ", "ALA", "C"),
        row(" CA ", "ALA", "CA"),
        row(" CA ", "ALA", ""),
        row("ZN  ", "ZN", "XX"),
        row("HG  ", "HG", "H"),
    ];
    assert_eq!(parse(Format::Pdb, text.concat()).elements, Some(vec![6, 20, 6, 30, 1]));
}

#[test]
fn pdb_alternatives_are_chosen_by_mean_occupancy() {
    let of = |name: &str, mark: char, x: f64, occupancy: f64| {
        atom("1", name, mark, "SER", "5", &format!("{x:>8.3}   0.000   0.000  {occupancy:.2} 10.00"))
    };
    let text = [
        of(" CA ", ' ', 1.0, 1.0),
        of(" CB ", 'A', 2.0, 0.8),
        of(" CB ", 'B', 3.0, 0.6),
        of(" OG ", 'A', 4.0, 0.2),
        of(" OG ", 'B', 5.0, 0.6),
        of(" HG ", 'A', 6.0, 0.2),
    ];
    let particles = parse(Format::Pdb, text.concat());
    assert_eq!(particles.positions.iter().map(|place| place[0]).collect::<Vec<_>>(), [1.0, 3.0, 5.0, 6.0]);
}

/// Residues 52 and 52A are two, in which other locations may be the best.
#[test]
fn alternatives_are_chosen_in_each_residue_by_itself() {
    let rows = [
        ("52", "?", 'A', 1.0, 0.7),
        ("52", "?", 'B', 2.0, 0.3),
        ("52", "A", 'A', 3.0, 0.2),
        ("52", "A", 'B', 4.0, 0.8),
        ("53", "?", 'A', 5.0, 0.6),
        ("53", "?", 'B', 6.0, 0.4),
    ];
    let pdb = rows.map(|(number, insertion, mark, x, occupancy)| {
        let line = atom(
            "1",
            " CA ",
            mark,
            "SER",
            number,
            &format!("{x:>8.3}   0.000   0.000  {occupancy:.2} 10.00"),
        );
        if insertion == "A" { line.replace("52 ", "52A") } else { line }
    });
    let names = ["id", "type_symbol", "label_atom_id", "label_alt_id", "auth_comp_id", "auth_asym_id"];
    let places = ["auth_seq_id", "pdbx_PDB_ins_code", "Cartn_x", "Cartn_y", "Cartn_z", "occupancy"];
    let names = names.iter().chain(&places).map(|name| format!("_atom_site.{name}\n"));
    let cif = rows.map(|(number, insertion, mark, x, occupancy)| {
        format!("1 C CA {mark} SER A {number} {insertion} {x} 0 0 {occupancy}\n")
    });
    let cif = format!("data_a\nloop_\n{}{}", names.collect::<String>(), cif.concat());
    for (format, text) in [(Format::Pdb, pdb.concat()), (Format::Mmcif, cif)] {
        let particles = parse(format, text);
        let x: Vec<f64> = particles.positions.iter().map(|place| place[0]).collect();
        assert_eq!(x, [1.0, 4.0, 5.0], "{format:?}");
    }
}

#[test]
fn pdb_models_cells_and_faults_are_understood() {
    let specimen = specimens().into_iter().find(|specimen| specimen.name == "pdb").unwrap();
    let particles = parse(Format::Pdb, &specimen.bytes);
    // Of A and B, which are alike in all, A stays, and the atom without a mark.
    assert_eq!((particles.len(), particles.title.as_str()), (2 * COUNT / 3, "SALTY WATER"));
    assert_eq!(particles.bonds, [[0, 1], [2, 3]]);
    let cell = particles.cell.unwrap();
    assert_eq!((cell.vectors[0], cell.vectors[1]), ([20.0, 0.0, 0.0], [0.0, 30.0, 0.0]));
    // What `END` separates are frames too, and what is empty is none.
    let line = atom("1", " C  ", ' ', "LIG", "1", "   1.000   2.000   3.000");
    let text = format!(
        "CRYST1    1.000    1.000    1.000  90.00  90.00  90.00 P 1\n{line}END\n{line}{line}END\nMODEL\nENDMDL\n"
    );
    let (_folder, path) = file("a.pdb", &text);
    assert_eq!(frames(&path).unwrap(), 2);
    let last = read(&path, &all(Frame::Last)).unwrap();
    assert_eq!((last.len(), last.cell), (2, None));
    // `SCALE` may turn the cell: here its first vector is along y.
    let scale =
        [(1, "0.000000  0.100000"), (2, "-.050000  0.000000"), (3, "0.000000  0.000000")].map(|(row, xy)| {
            format!(
                "SCALE{row}     {xy:>19} {:>9}        0.25000\n",
                if row == 3 { "0.040000" } else { "0.000000" }
            )
        });
    let text =
        format!("CRYST1   10.000   20.000   25.000  90.00  90.00  90.00 P 1\n{}{line}", scale.concat());
    let turned = parse(Format::Pdb, text).cell.unwrap();
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|axis| (a[axis] - b[axis]).abs() < SINGLE);
    assert!(
        near(turned.vectors[0], [0.0, 10.0, 0.0]) && near(turned.vectors[1], [-20.0, 0.0, 0.0]),
        "{turned:?}"
    );
    assert!(near(turned.origin, [5.0, -2.5, -6.25]), "{turned:?}");
    // Trajectories have a cell before each frame.
    let cell = |a: u8| format!("CRYST1   {a:>2}.000   20.000   30.000  90.00  90.00  90.00 P 1\n");
    let text = format!("{}MODEL\n{line}ENDMDL\n{}MODEL\n{line}ENDMDL\n", cell(10), cell(11));
    for (frame, length) in [(0, 10.0), (1, 11.0)] {
        let request = all(Frame::Number(frame));
        let particles = read_from("a", Cursor::new(&text), Format::Pdb, &request).unwrap();
        assert_eq!(particles.cell.unwrap().vectors[0], [length, 0.0, 0.0]);
    }
    let fault = |text: &str| fault(Format::Pdb, text);
    assert!(fault(&line.replace("2.000", "2,000")).starts_with(":1:39: \"2,000\" is no number"));
    assert!(fault("ATOM      1  CA\n").starts_with(":1:16: the line has 15 columns"));
    assert!(fault("HEADER\nCRYST1    x\n").starts_with(":2:7: \"x\" is no length"));
    assert!(fault("HEADER\n").contains("has no atoms"));
}
