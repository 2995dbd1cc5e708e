//! Dumps of LAMMPS.

use super::{fault, labels, parse};
use importers::{Format, Unit};

#[test]
fn dumps_are_sorted_and_their_boxes_understood() {
    let dump = |bounds: &str, atoms: &str| {
        format!(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS {atoms}\n"
        )
    };
    let particles = parse(
        Format::Dump,
        dump(
            "pp pp fs\n0 10\n0 20\n-5 5",
            "element id zs xs type ys diameter\nO 9 0.5 0.1 1 0.25 2\nSi 4 0 0 b 0 1",
        ),
    );
    assert_eq!(particles.positions, [[0.0, 0.0, -5.0], [1.0, 5.0, 0.0]]);
    assert_eq!((particles.elements, labels(particles.types.as_ref())), (Some(vec![14, 8]), vec!["b", "1"]));
    assert_eq!((particles.ids, particles.radii), (Some(vec![4, 9]), Some(vec![0.5, 1.0])));
    assert_eq!(particles.cell.unwrap().periodic, [true, true, false]);
    assert_eq!(particles.unit, Unit::Unknown);
    // A box repeats along an axis if both of its sides do; old versions say nothing, and mean all.
    let periodic = |sides: &str| {
        let text = dump(&format!("{sides}\n0 10\n0 20\n-5 5"), "x y z\n1 2 3\n4 5 6");
        parse(Format::Dump, text).cell.unwrap().periodic
    };
    assert_eq!(periodic("pp ps fp"), [true, false, false]);
    assert_eq!(periodic("ff pp mm"), [false, true, false]);
    assert_eq!(periodic(""), [true; 3]);
    // The bounds are those of the bounding box: the cell itself is 10 wide.
    let particles =
        parse(Format::Dump, dump("xy xz yz pp pp pp\n-2 13 3\n0 24 -2\n0 5 4", "x y z\n1 2 3\n4 5 6"));
    let cell = particles.cell.unwrap();
    assert_eq!(
        (cell.origin, cell.vectors),
        ([0.0, 0.0, 0.0], [[10.0, 0.0, 0.0], [3.0, 20.0, 0.0], [-2.0, 4.0, 5.0]])
    );
    // A general triclinic box, by its vectors and its origin.
    let general = dump("abc origin pp pp pp\n1 2 0 -1\n-3 1 0 -2\n0 1 4 -3", "xs ys zs\n1 0 0\n0 0.5 0.5");
    let particles = parse(Format::Dump, general);
    assert_eq!(particles.positions, [[0.0, 0.0, -3.0], [-2.5, -1.0, -1.0]]);
    // Sections that say nothing of particles are passed over, however long they are.
    let text = "ITEM: UNITS\nmetal\nITEM: TIMESTEP\n0\nITEM: TIME\n0.25\nITEM: WHAT MAY COME\n1 2 3\nx\n\n7\n\
                ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n1 2 3\n";
    let particles = parse(Format::Dump, text);
    assert_eq!((particles.positions, particles.unit), (vec![[1.0, 2.0, 3.0]], Unit::Angstrom));
    // Wrapped coordinates go before unwrapped ones.
    assert_eq!(
        parse(Format::Dump, dump("pp pp pp\n0 1\n0 1\n0 1", "xu yu zu x y z\n9 9 9 1 2 3\n9 9 9 4 5 6"))
            .positions[0],
        [1.0, 2.0, 3.0]
    );
}

#[test]
fn faults_of_dumps_are_told() {
    let fault = |text: &str| fault(Format::Dump, text);
    assert!(fault("ITEM: TIMESTEP\n0\n1 2 3\n").starts_with(":3: \"1 2 3\" is no section"));
    assert!(fault("ITEM: ATOMS id x y z\n").contains("NUMBER OF ATOMS is missing"));
    assert!(
        fault("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id vx\n1 2 \n")
            .starts_with(":3: the columns have no coordinates")
    );
    assert!(fault("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS xs ys zs\n1 2 3\n").contains("need BOX BOUNDS"));
    assert!(
        fault("ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0\n")
            .starts_with(":5: \"0\" has no 2 numbers")
    );
    assert!(
        fault("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id x y z\n-1 2 3 4\n")
            .starts_with(":4:1: \"-1\" is no id")
    );
    assert!(fault("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n1 2 3 4\n").contains("beyond the 3 fields"));
}
