//! Elements by the names of atoms, for files that do not state elements.

use crate::elements::by_symbol;
use crate::text::trimmed;

/// Residues whose atoms are of C, H, N, O, P and S alone: amino acids, nucleotides, water.
const PLAIN_RESIDUES: &[&str] = &[
    "ALA", "ARG", "ASN", "ASP", "ASH", "CYS", "CYX", "CYM", "GLN", "GLU", "GLH", "GLY", "HIS", "HID", "HIE",
    "HIP", "HSD", "HSE", "HSP", "ILE", "LEU", "LYS", "LYN", "MET", "PHE", "PRO", "SER", "THR", "TRP", "TYR",
    "VAL", "ACE", "NME", "NMA", "NH2", "A", "C", "G", "U", "I", "DA", "DC", "DG", "DT", "DU", "RA", "RC",
    "RG", "RU", "HOH", "SOL", "WAT", "TIP", "TIP3", "TIP4", "TP3", "TP4", "SPC", "H2O", "DOD",
];

/// Names of ions in force fields that are not their symbols.
const IONS: &[(&str, u8)] =
    &[("SOD", 11), ("CLA", 17), ("POT", 19), ("CAL", 20), ("CES", 55), ("RUB", 37), ("LIT", 3)];

/// The element of an atom by its name and its residue; 0 if neither tells.
pub(crate) fn element(name: &[u8], residue: &[u8]) -> u8 {
    let (Ok(name), Ok(residue)) =
        (std::str::from_utf8(name.trim_ascii()), std::str::from_utf8(residue.trim_ascii()))
    else {
        return 0;
    };
    let name = name.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '\'' | '"' | '*'));
    let letters = &name[..name.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(name.len())];
    if letters.is_empty() {
        return 0;
    }
    if is_plain(residue) {
        return one_letter(letters);
    }
    let of_residue = &residue[..residue.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(residue.len())];
    if of_residue.eq_ignore_ascii_case(letters) {
        // An ion is a residue of its own, and called like it.
        let ion = IONS.iter().find(|(ion, _)| ion.eq_ignore_ascii_case(letters)).map(|&(_, number)| number);
        if let Some(number) = ion.or_else(|| by_symbol(letters)) {
            return number;
        }
    }
    let two = letters.get(..2).and_then(by_symbol);
    let is_written_so = letters.as_bytes().get(1).is_some_and(u8::is_ascii_lowercase);
    let is_halogen = matches!(two, Some(17 | 35)) && letters.len() == 2;
    match (two, one_letter(letters)) {
        (Some(number), _) if is_written_so || is_halogen => number,
        (Some(number), 0) | (_, number) => number,
    }
}

/// The element of an atom of a PDB file by the four columns of its name, in which symbols end at the second.
pub(crate) fn element_by_columns(name: [u8; 4], residue: &[u8]) -> u8 {
    let text = std::str::from_utf8(residue.trim_ascii()).unwrap_or_default();
    let is_full_hydrogen = name[0] == b'H' && name[3] != b' ';
    if name[0].is_ascii_alphabetic() && name[1].is_ascii_alphabetic() && !is_plain(text) && !is_full_hydrogen
    {
        let symbol = std::str::from_utf8(&name[..2]).ok().and_then(by_symbol);
        if let Some(number) = symbol {
            return number;
        }
    }
    let is_short = !name[0].is_ascii_alphabetic() && name[1].is_ascii_alphabetic();
    let first = one_letter(std::str::from_utf8(&name[1..2]).unwrap_or_default());
    if is_short && first > 0 { first } else { element(trimmed(&name), residue) }
}

fn is_plain(residue: &str) -> bool {
    PLAIN_RESIDUES.contains(&residue)
}

/// The element of the first letter, among those that names of atoms begin with.
fn one_letter(letters: &str) -> u8 {
    match letters.as_bytes().first().map(u8::to_ascii_uppercase) {
        Some(b'H' | b'D') => 1,
        Some(b'B') => 5,
        Some(b'C') => 6,
        Some(b'N') => 7,
        Some(b'O') => 8,
        Some(b'F') => 9,
        Some(b'P') => 15,
        Some(b'S') => 16,
        Some(b'K') => 19,
        Some(b'I') => 53,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_elements_by_their_residue() {
        let of = |name: &str, residue: &str| element(name.as_bytes(), residue.as_bytes());
        assert_eq!([of("CA", "ALA"), of("CA", "CA"), of("CA", "LIG")], [6, 20, 6]);
        assert_eq!([of("OW", "SOL"), of("HW1", "SOL"), of("MW", "SOL")], [8, 1, 0]);
        assert_eq!([of("NA", "NA"), of("NA+", "NA+"), of("SOD", "SOD"), of("Cl-", "Cl-")], [11, 11, 11, 17]);
        assert_eq!([of("1HB", "VAL"), of("Cl1", "LIG"), of("CL2", "LIG"), of("ZN", "LIG")], [1, 17, 17, 30]);
        assert_eq!([of("", ""), of("'", "X"), of("XQ", "LIG")], [0, 0, 0]);
    }

    #[test]
    fn columns_of_pdb_names_tell_elements() {
        let of = |name: &[u8; 4], residue: &str| element_by_columns(*name, residue.as_bytes());
        assert_eq!(
            [of(b" CA ", "ALA"), of(b"CA  ", " CA"), of(b" C1 ", "LIG"), of(b"FE  ", "HEM")],
            [6, 20, 6, 26]
        );
        assert_eq!(
            [of(b"HG11", "VAL"), of(b"HG  ", " HG"), of(b"1HB ", "VAL"), of(b"SE  ", "MSE")],
            [1, 80, 1, 34]
        );
        assert_eq!([of(b"    ", ""), of(b" H1'", "A"), of(b"HO5'", "LIG")], [0, 1, 1]);
    }
}
