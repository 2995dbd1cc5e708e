//! Alternative locations: of atoms that a structure has in several places, one place each is read.
//!
//! In each residue that location is taken whose atoms have the highest mean occupancy; among equals the lowest mean B
//! factor; among equals the first by alphabet, as `ChimeraX` does. An atom that the location lacks keeps the best one it
//! has, unless another kind of residue stands there.

use std::cmp::Ordering;
use std::collections::HashMap;

/// An atom with a mark of its location.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alternative {
    /// The atom's row.
    pub(crate) row: u32,
    pub(crate) residue: Residue,
    /// Indices of the labels.
    pub(crate) residue_name: u16,
    pub(crate) name: u16,
    /// The text of the mark: see [`packed`].
    pub(crate) mark: u64,
    pub(crate) occupancy: f32,
    pub(crate) b_factor: f32,
}

/// What residues are told apart by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Residue {
    pub(crate) chain: u16,
    pub(crate) number: i32,
    /// The text of the insertion code: see [`packed`].
    pub(crate) insertion: u64,
}

/// The first eight bytes of a text as a number, with the same order; the marks of files have one or two.
pub(crate) fn packed(text: &[u8]) -> u64 {
    let mut bytes = [0; 8];
    let length = text.len().min(bytes.len());
    bytes[..length].copy_from_slice(&text[..length]);
    u64::from_be_bytes(bytes)
}

/// An atom of a disordered part of a crystal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disordered {
    /// The atom's row.
    pub(crate) row: u32,
    /// The text of its assembly, of which the groups are alternatives: see [`packed`].
    pub(crate) assembly: u64,
    /// The text of its group.
    pub(crate) group: u64,
    pub(crate) occupancy: f32,
}

/// Strikes out the atoms that are not in the group of the highest mean occupancy of their assembly, among equals the first.
fn keep_one_group(mut atoms: Vec<Disordered>, keep: &mut [bool]) {
    atoms.sort_by_key(|atom| (atom.assembly, atom.group, atom.row));
    for assembly in atoms.chunk_by(|a, b| a.assembly == b.assembly) {
        let groups = || assembly.chunk_by(|a, b| a.group == b.group);
        let mean = |group: &[Disordered]| {
            group.iter().map(|atom| f64::from(atom.occupancy)).sum::<f64>() / group.len() as f64
        };
        let rank =
            |a: &&[Disordered], b: &&[Disordered]| mean(b).total_cmp(&mean(a)).then(a[0].row.cmp(&b[0].row));
        let best = groups().min_by(rank).map(|group| group[0].group);
        for atom in assembly {
            keep[atom.row as usize] &= Some(atom.group) == best;
        }
    }
}

/// Means of the atoms of a residue at a location.
#[derive(Clone, Copy, Default)]
struct Mean {
    count: f64,
    occupancy: f64,
    b_factor: f64,
}

/// Which of `rows` rows stay, of macromolecules and of disordered crystals; `None` if all do.
pub(crate) fn kept(
    mut alternatives: Vec<Alternative>,
    disordered: Vec<Disordered>,
    rows: usize,
) -> Option<Vec<bool>> {
    if alternatives.is_empty() && disordered.is_empty() {
        return None;
    }
    let mut keep = vec![true; rows];
    alternatives.sort_by_key(|atom| atom.residue);
    for residue in alternatives.chunk_by(|a, b| a.residue == b.residue) {
        choose(residue, &mut keep);
    }
    keep_one_group(disordered, &mut keep);
    Some(keep)
}

/// Strikes out the atoms of a residue that are not at the best location.
fn choose(residue: &[Alternative], keep: &mut [bool]) {
    let mut means: HashMap<u64, Mean> = HashMap::new();
    for atom in residue {
        let mean = means.entry(atom.mark).or_default();
        mean.count += 1.0;
        mean.occupancy += f64::from(atom.occupancy);
        mean.b_factor += f64::from(atom.b_factor);
    }
    let rank = |a: &Alternative, b: &Alternative| better(a.mark, b.mark, &means);
    let Some(best) = residue.iter().min_by(|a, b| rank(a, b)) else { return };
    // The best place of each name.
    let mut chosen: HashMap<u16, &Alternative> = HashMap::new();
    for atom in residue.iter().filter(|atom| atom.mark == best.mark || atom.residue_name == best.residue_name)
    {
        let held = chosen.entry(atom.name).or_insert(atom);
        if rank(atom, held) == Ordering::Less {
            *held = atom;
        }
    }
    for atom in residue {
        keep[atom.row as usize] = chosen.get(&atom.name).is_some_and(|chosen| chosen.row == atom.row);
    }
}

fn better(a: u64, b: u64, means: &HashMap<u64, Mean>) -> Ordering {
    let (of_a, of_b) = (means[&a], means[&b]);
    let occupancy = |mean: Mean| mean.occupancy / mean.count;
    let b_factor = |mean: Mean| mean.b_factor / mean.count;
    occupancy(of_b)
        .total_cmp(&occupancy(of_a))
        .then(b_factor(of_a).total_cmp(&b_factor(of_b)))
        .then(a.cmp(&b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn atom(row: u32, name: u16, mark: u8, occupancy: f32, b_factor: f32) -> Alternative {
        let residue = Residue { chain: 0, number: 7, insertion: 0 };
        Alternative { row, residue, residue_name: 0, name, mark: packed(&[mark]), occupancy, b_factor }
    }

    /// However many atoms a group has, and whichever other assemblies there are.
    #[test]
    fn of_an_assembly_the_group_of_the_highest_mean_occupancy_stays() {
        let kept_of = |atoms: &[(u8, u8, f32)]| {
            let rows = atoms.iter().zip(0..).map(|(&(assembly, group, occupancy), row)| Disordered {
                row,
                assembly: packed(&[assembly]),
                group: packed(&[group]),
                occupancy,
            });
            let keep = kept(Vec::new(), rows.collect(), atoms.len()).unwrap();
            (0..atoms.len()).filter(|&row| keep[row]).collect::<Vec<_>>()
        };
        let three_and_one = [(b'A', b'1', 0.3), (b'A', b'1', 0.3), (b'A', b'2', 0.7), (b'A', b'1', 0.3)];
        assert_eq!(kept_of(&three_and_one), [2]);
        assert_eq!(kept_of(&[(b'A', b'1', 0.5), (b'A', b'2', 0.5)]), [0]);
        assert_eq!(
            kept_of(&[(b'A', b'1', 0.2), (b'B', b'1', 0.9), (b'A', b'2', 0.8), (b'B', b'2', 0.1)]),
            [1, 2]
        );
    }

    #[test]
    fn the_highest_mean_occupancy_wins_then_the_lowest_b_then_the_alphabet() {
        let keep = |atoms: Vec<Alternative>| {
            let rows = atoms.len() + 1;
            let keep = kept(atoms, Vec::new(), rows).unwrap();
            (0..rows).filter(|&row| keep[row]).collect::<Vec<_>>()
        };
        // Atom 4 has no alternatives. One atom of A has a higher occupancy than B's, but not their mean.
        let atoms = vec![
            atom(0, 1, b'A', 0.8, 1.0),
            atom(1, 1, b'B', 0.6, 1.0),
            atom(2, 2, b'A', 0.2, 1.0),
            atom(3, 2, b'B', 0.6, 1.0),
        ];
        assert_eq!(keep(atoms), [1, 3, 4]);
        assert_eq!(keep(vec![atom(0, 1, b'A', 0.5, 9.0), atom(1, 1, b'B', 0.5, 8.0)]), [1, 2]);
        assert_eq!(keep(vec![atom(0, 1, b'B', 0.5, 9.0), atom(1, 1, b'A', 0.5, 9.0)]), [1, 2]);
        // The mean of A's two is lower than that of B's one, and their sum higher.
        let atoms = vec![atom(0, 1, b'A', 0.5, 5.0), atom(1, 2, b'A', 0.5, 5.0), atom(2, 1, b'B', 0.5, 8.0)];
        assert_eq!(keep(atoms), [0, 1, 3]);
        // An atom that B lacks stays, unless B is another kind of residue.
        let mut atoms =
            vec![atom(0, 1, b'A', 0.4, 1.0), atom(1, 1, b'B', 0.6, 1.0), atom(2, 3, b'A', 0.4, 1.0)];
        assert_eq!(keep(atoms.clone()), [1, 2, 3]);
        (atoms[0].residue_name, atoms[2].residue_name) = (5, 5);
        assert_eq!(keep(atoms), [1, 3]);
    }

    #[test]
    fn residues_are_chosen_apart_wherever_their_atoms_stand() {
        let mut atoms = vec![
            atom(0, 1, b'A', 0.9, 1.0),
            atom(1, 1, b'A', 0.1, 1.0),
            atom(2, 1, b'B', 0.1, 1.0),
            atom(3, 1, b'B', 0.9, 1.0),
        ];
        (atoms[1].residue.number, atoms[3].residue.number) = (8, 8);
        assert_eq!(kept(atoms, Vec::new(), 4).unwrap(), [true, false, false, true]);
        assert_eq!(kept(Vec::new(), Vec::new(), 4), None);
    }
}
