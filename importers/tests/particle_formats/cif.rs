//! CIF and mmCIF files.

use super::{all, fault, file, labels, parse};
use crate::specimens::{COUNT, specimens};
use importers::{Format, Frame, Request, frames, read, read_from};
use std::io::Cursor;

#[test]
fn mmcif_names_bonds_and_models_are_read() {
    let specimen = specimens().into_iter().find(|specimen| specimen.name == "mmcif").unwrap();
    let particles = parse(Format::Mmcif, &specimen.bytes);
    assert_eq!((particles.len(), particles.title.as_str()), (COUNT, "salty water"));
    assert_eq!(labels(particles.names.as_ref())[..3], ["O", "H1", "H2'"]);
    assert_eq!(particles.bonds, [[0, 1]], "that of hydrogen is none");
    let fault = |text: &str| fault(Format::Mmcif, text);
    let with = |rows: &str| {
        format!(
            "data_a\nloop_\n_atom_site.id\n_atom_site.type_symbol\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n{rows}"
        )
    };
    let good = parse(Format::Mmcif, with("1 C 1 2 3\n2 FE\n4 5\n6\n"));
    assert_eq!((good.positions[1], good.elements), ([4.0, 5.0, 6.0], Some(vec![6, 26])));
    assert!(
        fault(&with("1 C 1 2 3\n2 C 1 2 ?\n")).starts_with(":9:9: \"\" is no number"),
        "{}",
        fault(&with("1 C 1 2 3\n2 C 1 2 ?\n"))
    );
    assert!(fault(&with("1 C 1 2 3\n2 C 1 2\n")).contains("a row of the loop has 4 of 5 values"));
    assert!(fault("data_a\n'open\n").starts_with(":2:2: a quotation mark"));
    assert!(fault("data_a\n_b\n").contains("\"_b\" has no value"));
    assert!(fault("data_a\n").contains("has no atoms"));
    let alone = "data_a\n_atom_site.id 1\n_atom_site.type_symbol He\n_atom_site.Cartn_x 1\n_atom_site.Cartn_y 2\n_atom_site.Cartn_z 3\n";
    assert_eq!(parse(Format::Mmcif, alone).positions, [[1.0, 2.0, 3.0]]);
    let group = "data_a\n_cell_length_a 2\n_cell_length_b 2\n_cell_length_c 2\n_symmetry_space_group_name_H-M 'F m -3 m'\nloop_\n\
                 _atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\nNa1 0.5 0.25(2) -1\n";
    assert!(fault(group).contains("lists no _space_group_symop_operation_xyz"));
    assert_eq!(parse(Format::Mmcif, group.replace("F m -3 m", "P 1")).positions, [[1.0, 0.5, -2.0]]);
}

/// Columns of `_atom_site` that bonds need as well.
const ATOM_SITES: [&str; 8] =
    ["id", "type_symbol", "auth_asym_id", "auth_seq_id", "label_atom_id", "Cartn_x", "Cartn_y", "Cartn_z"];

/// Models have numbers of their own, which need not begin at 1; and a bond to another image of the crystal is none within it.
#[test]
fn mmcif_models_are_frames_and_bonds_stay_within_the_crystal() {
    let names = ATOM_SITES.iter().chain(&["pdbx_PDB_model_num"]).map(|name| format!("_atom_site.{name}\n"));
    let ends = |end: u8| {
        ["auth_asym_id", "auth_seq_id", "label_atom_id", "symmetry"]
            .map(|name| format!("_struct_conn.ptnr{end}_{name}\n"))
            .concat()
    };
    let text = format!(
        "data_a\nloop_\n{}1 C A 1 CA 1 0 0 4\n2 C A 2 CA 2 0 0 4\n3 C A 3 CA 3 0 0 4\n4 O A 1 OW 4 0 0 7\n5 O A 1 OW 5 0 0 2\n\
         6 O A 2 OW 6 0 0 2\nloop_\n_struct_conn.conn_type_id\n{}{}covale A 1 CA 1_555 A 2 CA 1_555\n\
         metalc A 2 CA 1_555 A 3 CA 2_655\ndisulf A 1 CA 3_555 A 3 CA 3_555\n",
        names.collect::<String>(),
        ends(1),
        ends(2)
    );
    let (_folder, path) = file("a.cif", &text);
    assert_eq!(frames(&path).unwrap(), 3);
    let of = |frame| read(&path, &all(frame)).unwrap();
    let x = |frame| of(frame).positions.iter().map(|p| p[0]).collect::<Vec<_>>();
    let models = [0, 1, 2].map(|number| x(Frame::Number(number)));
    assert_eq!(models, [vec![1.0, 2.0, 3.0], vec![4.0], vec![5.0, 6.0]]);
    assert_eq!(x(Frame::Last), [5.0, 6.0]);
    assert_eq!(of(Frame::Number(0)).bonds, [[0, 1], [0, 2]]);
}

/// A structure with one bond states it without a loop, before its atoms or after them; the rules are those of a row.
#[test]
fn a_single_bond_of_mmcif_needs_no_loop() {
    let columns = ATOM_SITES.map(|name| format!("_atom_site.{name}\n")).concat();
    let atoms = format!("loop_\n{columns}1 S A 1 SG 1 0 0\n2 S B 7 SG 2 0 0\n");
    let bond = |kind: &str, images: [&str; 2]| {
        format!(
            "_struct_conn.id x1\n_struct_conn.conn_type_id {kind}\n_struct_conn.ptnr1_label_atom_id SG\n\
             _struct_conn.ptnr1_auth_asym_id A\n_struct_conn.ptnr1_auth_seq_id 1\n_struct_conn.ptnr1_symmetry {}\n\
             _struct_conn.ptnr2_auth_asym_id B\n_struct_conn.ptnr2_auth_seq_id 7\n_struct_conn.ptnr2_label_atom_id SG\n\
             _struct_conn.ptnr2_symmetry {}\n#\n",
            images[0], images[1]
        )
    };
    for (kind, images, bonds) in [
        ("disulf", ["1_555", "1_555"], &[[0, 1]][..]),
        ("covale", ["?", "?"], &[[0, 1]]),
        ("hydrog", ["1_555", "1_555"], &[]),
        ("disulf", ["1_555", "2_655"], &[]),
    ] {
        let bond = bond(kind, images);
        for text in [
            format!("data_a\n{bond}{atoms}"),
            format!("data_a\n{atoms}{bond}"),
            format!("data_a\n{atoms}{bond}data_b\n"),
        ] {
            assert_eq!(parse(Format::Mmcif, &text).bonds, bonds, "{text}");
        }
    }
    // Of a block without atoms before it nothing is left.
    let other = format!("data_a\n{}data_b\n{atoms}", bond("disulf", ["?", "?"]));
    assert_eq!(parse(Format::Mmcif, &other).bonds, [[0; 2]; 0]);
}

/// Of several blocks the first with atoms is read as if it stood alone: no other says anything of its cell, its symmetry, its
/// bonds or its atoms.
#[test]
fn blocks_of_cif_say_nothing_of_each_other() {
    let site = |names: &[&str], prefix: &str, rows: &str| {
        let names = names.iter().map(|name| format!("{prefix}{name}\n")).collect::<Vec<_>>().concat();
        format!("loop_\n{names}{rows}")
    };
    let cell = |length: u8| ["a", "b", "c"].map(|side| format!("_cell_length_{side} {length}\n")).concat();
    let molecule = site(&ATOM_SITES, "_atom_site.", "1 C A 1 CA 1 2 3\n2 C A 2 CA 4 5 6\n");
    let crystal =
        cell(4) + &site(&["label", "fract_x", "fract_y", "fract_z"], "_atom_site_", "Na1 0.25 0.5 0.125\n");
    let alone = "_atom_site.id 1\n_atom_site.type_symbol He\n_atom_site.Cartn_x 1\n_atom_site.Cartn_y 2\n_atom_site.Cartn_z 3\n";
    let without_atoms = [
        cell(7),
        "_cell_angle_beta 100\n".into(),
        "_struct.title another\n".into(),
        "_symmetry_space_group_name_H-M 'F m -3 m'\n".into(),
        "loop_\n_symmetry_equiv_pos_as_xyz\nx,y,z\n-x,-y,-z\n".into(),
        site(
            &["conn_type_id", "ptnr1_auth_asym_id", "ptnr1_auth_seq_id", "ptnr1_label_atom_id"],
            "_struct_conn.",
            "",
        ) + "_struct_conn.ptnr2_auth_asym_id\n_struct_conn.ptnr2_auth_seq_id\n_struct_conn.ptnr2_label_atom_id\n\
             covale A 1 CA A 2 CA\n",
        // What is known of atoms that have no place.
        "_atom_site.type_symbol Fe\n_atom_site.label_atom_id FE\n".into(),
        site(&["label", "occupancy"], "_atom_site_", "Na1 0.5\n"),
        String::new(),
    ];
    let parse = |text: &str| {
        read_from("a", Cursor::new(text.as_bytes()), Format::Mmcif, &Request::default()).unwrap()
    };
    for (atoms, count) in [(molecule.as_str(), 2), (&crystal, 1), (alone, 1)] {
        let block = format!("data_a\n{atoms}");
        let right = parse(&block);
        assert_eq!((right.len(), right.bonds.len(), right.title.as_str()), (count, 0, ""));
        assert_eq!(right.cell.is_some(), atoms == crystal);
        for other in without_atoms.iter().map(String::as_str).chain([without_atoms.concat().as_str()]) {
            let before = parse(&format!("data_other\n{other}{block}"));
            assert_eq!(before, right, "after {other}");
        }
        for other in without_atoms.iter().map(String::as_str).chain([molecule.as_str(), &crystal, alone]) {
            let after = parse(&format!("{block}data_other\n{other}"));
            assert_eq!(after, right, "before {other}");
        }
    }
}

/// Of each assembly the group of the highest mean occupancy stays, among equals the first; atoms without a group stay.
#[test]
fn of_disordered_groups_one_is_read() {
    let text = "data_a\n_cell_length_a 10\n_cell_length_b 10\n_cell_length_c 10\nloop_\n_atom_site_label\n_atom_site_fract_x\n\
                _atom_site_fract_y\n_atom_site_fract_z\n_atom_site_occupancy\n_atom_site_disorder_assembly\n\
                _atom_site_disorder_group\nC1 .1 0 0 1 . .\nC2A .2 0 0 0.4(1) A 1\nC2B .3 0 0 0.6 A 2\nC3A .4 0 0 0.4 A 1\n\
                C3B .5 0 0 0.6 A 2\nO4B .6 0 0 0.5 B 2\nO4A .7 0 0 0.5 B 1\nN5 .8 0 0 0.5 . -1\n";
    let x = |text: &str| parse(Format::Mmcif, text).positions.iter().map(|p| p[0]).collect::<Vec<_>>();
    assert_eq!(x(text), [1.0, 3.0, 5.0, 6.0, 8.0]);
    assert_eq!(x(&text.replace("0.4", "0.7")), [1.0, 2.0, 4.0, 6.0, 8.0]);
    // An occupancy that is not stated is whole.
    assert_eq!(x(&text.replace("0.4(1)", "?").replace("0.4", ".")), [1.0, 2.0, 4.0, 6.0, 8.0]);
}

/// Both are in the files of the PDB: authors' numbers are those that papers name, and names of atoms are the standard's.
#[test]
fn chains_and_numbers_of_mmcif_are_those_of_the_authors() {
    let with = |names: &str, row: &str| {
        let names = names.split(' ').map(|name| format!("_atom_site.{name}\n")).collect::<Vec<_>>().concat();
        // The unit cube of a structure that is no crystal.
        let cell = ["a", "b", "c"].map(|side| format!("_cell.length_{side} 1.000\n")).concat();
        parse(Format::Mmcif, format!("data_a\n{cell}loop_\n{names}{row}\n"))
    };
    let standard =
        "id type_symbol label_atom_id label_comp_id label_asym_id label_seq_id Cartn_x Cartn_y Cartn_z";
    let own = "auth_seq_id auth_comp_id auth_asym_id auth_atom_id";
    for (names, row, expected) in [
        (format!("{standard} {own}"), "1 Fe3+ M1 LA X 1 1 2 3 101 AU A N1", ("M1", "AU", "A", 101)),
        (format!("{own} {standard}"), "101 AU A N1 1 Fe3+ M1 LA X 1 1 2 3", ("M1", "AU", "A", 101)),
        (standard.to_owned(), "1 Fe3+ M1 LA X 1 1 2 3", ("M1", "LA", "X", 1)),
    ] {
        let particles = with(&names, row);
        let first = |column: &Option<importers::Labels>| labels(column.as_ref())[0].to_owned();
        let [name, residue, chain] = [&particles.names, &particles.residues, &particles.chains].map(first);
        let number = particles.residue_numbers.as_ref().unwrap()[0];
        assert_eq!((&*name, &*residue, &*chain, number), expected, "{names}");
        // By the symbol, whatever its charge.
        assert_eq!((particles.elements, particles.cell), (Some(vec![26]), None));
    }
}
