//! XYZ files, plain and extended.

use super::{fault, labels, parse};
use importers::{Cell, Format};

#[test]
fn labels_that_are_no_symbols_are_types() {
    let particles = parse(Format::Xyz, "5\n\nC 0 0 0\nFe2 0 0 0\nbead 0 0 0\n8 0 0 0\nH+ 0 0 0\n");
    assert_eq!(particles.elements.as_deref(), Some(&[6, 26, 0, 0, 1][..]));
    assert_eq!(labels(particles.types.as_ref()), ["C", "Fe2", "bead", "8", "H+"]);
    let particles = parse(Format::Xyz, "2\n\nna 0 0 0\nCL 0 0 0\n");
    assert_eq!((particles.elements, particles.types), (Some(vec![11, 17]), None));
    let text = "1\nProperties=type:I:1:element:S:1:pos:R:3\n7 Au 1 2 3\n";
    let particles = parse(Format::Xyz, text);
    assert_eq!((particles.elements, labels(particles.types.as_ref())), (Some(vec![79]), vec!["7"]));
    // A column of types goes before labels, which tell elements.
    let text = "1\nProperties=species:S:1:pos:R:3:type:I:1\nFe2 1 2 3 7\n";
    let particles = parse(Format::Xyz, text);
    assert_eq!((particles.elements, labels(particles.types.as_ref())), (Some(vec![26]), vec!["7"]));
    let particles = parse(Format::Xyz, "1\nProperties=Z:I:1:pos:R:3\n79 1 2 3\n");
    assert_eq!(particles.elements, Some(vec![79]));
}

#[test]
fn comments_of_plain_xyz_may_hold_anything() {
    let particles = parse(Format::Xyz, "1\nit's \"odd = 3 [\nO 1 2 3 4.5 x\n");
    assert_eq!((particles.title.as_str(), particles.cell), ("it's \"odd = 3 [", None));
    assert_eq!(particles.property("column_5"), Some(&[4.5][..]));
    let particles =
        parse(Format::Xyz, "1\nLattice=\"1 0 0 0 1 0 0 0 1\" Origin=\"-1 0 2\" pbc=\"F F T\"\nO 1 2 3\n");
    let cell = particles.cell.unwrap();
    assert_eq!((cell.origin, cell.periodic), ([-1.0, 0.0, 2.0], [false, false, true]));
}

/// Columns of several fields are as wide as they say, also those that mean nothing here.
#[test]
fn columns_of_extended_xyz_are_what_their_names_say() {
    let text = "2\nProperties=atom_name:S:1:note:S:2:resname:S:1:chain:S:1:mol:I:1:pos:R:3:forces:R:3:spin:R:2\n\
                CA p q ALA A 7 1 2 3 0.5 0.25 0.75 8 9\nOW r s SOL B 3 4 5 6 1.5 1.25 1.75 6 5\n";
    let particles = parse(Format::Xyz, text);
    assert_eq!(labels(particles.names.as_ref()), ["CA", "OW"]);
    assert_eq!(labels(particles.residues.as_ref()), ["ALA", "SOL"]);
    assert_eq!(labels(particles.chains.as_ref()), ["A", "B"]);
    assert_eq!((&particles.molecules, &particles.types), (&Some(vec![7, 3]), &None));
    assert_eq!(particles.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(particles.available, ["forces_x", "forces_y", "forces_z", "spin_0", "spin_1"]);
    for (name, values) in [("forces_y", [0.25, 1.25]), ("spin_0", [8.0, 6.0]), ("spin_1", [9.0, 5.0])] {
        assert_eq!(particles.property(name), Some(&values[..]), "{name}");
    }
}

#[test]
fn truths_of_pbc_are_written_in_many_ways() {
    let periodic = |pbc: &str| {
        let text = format!("1\nLattice=\"4 5 6\" pbc={pbc}\nO 1 2 3\n");
        parse(Format::Xyz, text).cell.unwrap().periodic
    };
    for pbc in ["\"T F T\"", "\"1 0 1\"", "[True, False, True]", "{true false true}", "[T,F,T]"] {
        assert_eq!(periodic(pbc), [true, false, true], "{pbc}");
    }
    let wrong = fault(Format::Xyz, "1\nLattice=\"4 5 6\" pbc=\"T F\"\nO 1 2 3\n");
    assert!(wrong.starts_with(":2: pbc=\"T F\" is wrong"), "{wrong}");
}

#[test]
fn lattices_are_vectors_or_lengths_of_edges() {
    let cell = |comment: &str| parse(Format::Xyz, format!("1\n{comment}\nO 1 2 3\n")).cell;
    let right = Cell {
        origin: [0.0; 3],
        vectors: [[4.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 6.5]],
        periodic: [true, true, false],
    };
    for lattice in [
        "Lattice=\"4 0 0 0 5 0 0 0 6.5\"",
        "Lattice=\"4 5 6.5\"",
        "lattice={4 5 6.5}",
        "Lattice=[4, 5, 6.5]",
        "Lattice=[[4, 0, 0], [0, 5, 0], [0, 0, 6.5]]",
        "Lattice = \"4 5 6.5\"",
        "Properties = species:S:1:pos:R:3 Lattice=\"4 5 6.5\"",
    ] {
        assert_eq!(cell(&format!("{lattice} pbc=\"T T F\"")), Some(right), "{lattice}");
    }
    // Free text.
    for comment in ["the lattice = cubic", "sublattice=\"4 5 6\"", "no lattice", "lattice constant=\"4\""] {
        assert_eq!(cell(comment), None, "{comment}");
    }
}

#[test]
fn faults_of_xyz_are_told_with_line_and_column() {
    let fault = |text: &str| fault(Format::Xyz, text);
    assert_eq!(
        fault("2\n\nO 1 2 3\nO 1 x 3\n"),
        ":4:5: \"x\" is no number; a coordinate is one, such as 1.5"
    );
    assert_eq!(fault("2\n\nO 1 2 3\nO 1 2\n"), ":4:6: the line has 3 of 4 fields: a symbol and x, y, z");
    assert_eq!(fault("2\n\nO 1 2 3\n"), ":4: the file ends after 1 of 2 particles");
    assert_eq!(fault("9999\n\nO 1 2 3\n"), ":3: the file is too short for the 9999 particles it announces");
    assert_eq!(fault("1\n\nO 1 nan 3\n"), ":3:5: the coordinate is NaN; coordinates are finite numbers");
    assert_eq!(fault("1\n\nO 1 1e99 3\n"), ":3:5: the coordinate 1e99 is too far away: at most 1e30");
    assert!(fault("O 1 2 3\n").starts_with(":1: \"O 1 2 3\" is no number of atoms"));
    assert_eq!(fault(""), ": has no frame: the file is empty");
    let extended = |properties: &str| fault(&format!("1\nProperties={properties}\nO 1 2 3\n"));
    assert!(extended("species:S:1:pos:R").starts_with(":2: \"pos:R\" in Properties is no column"));
    assert!(extended("species:S:1").starts_with(":2: Properties has no positions"));
    assert_eq!(
        extended("species:S:1:pos:R:3:q:R:1"),
        ":3:8: the line has 4 of 5 fields: species, pos (3), q"
    );
    assert_eq!(extended("pos:R:3"), ":3:1: \"O\" is no number; a coordinate is one, such as 1.5");
    assert!(fault("1\nLattice=\"1 2\nO 1 2 3\n").contains("the value of \"Lattice\" has no end"));
    for numbers in ["", "1 2", "1 2 3 4", "4 5 6 90 90 90", "4 5 x"] {
        let line = fault(&format!("1\nLattice=\"{numbers}\"\nO 1 2 3\n"));
        let right = "is no cell; it is nine numbers, three for each vector, or three lengths of edges";
        assert_eq!(line, format!(":2: Lattice=\"{numbers}\" {right}"));
    }
    assert!(fault("1\nLattice=4 5 6\nO 1 2 3\n").starts_with(":2: Lattice=\"4\" is no cell"));
}

#[test]
fn a_fault_far_down_is_told_with_its_line() {
    let mut text = String::from("200000\n\n");
    (0..199_999).for_each(|_| text.push_str("O 1.25 2.25 3.25\n"));
    text.push_str("O 1 2 -\n");
    assert!(fault(Format::Xyz, &text).starts_with(":200002:7: \"-\" is no number"));
    let particles = parse(Format::Xyz, text.replace("O 1 2 -", "bead 1 2 3"));
    assert_eq!((particles.len(), particles.positions[199_999]), (200_000, [1.0, 2.0, 3.0]));
    assert_eq!(particles.elements.unwrap()[199_998..], [8, 0]);
}
