//! The elements: symbols, radii and colours.
//!
//! - Covalent radii: B. Cordero and others, "Covalent radii revisited", Dalton Transactions 2008, 2832
//!   (doi:10.1039/b801115j), to curium. Carbon as sp3; manganese, iron and cobalt as low spin.
//! - Van der Waals radii: A. Bondi, "Van der Waals volumes and radii", J. Phys. Chem. 68, 441 (1964)
//!   (doi:10.1021/j100785a001); other elements of the main groups by M. Mantina and others, "Consistent van der Waals radii
//!   for the whole main group", J. Phys. Chem. A 113, 5806 (2009) (doi:10.1021/jp8111556).
//! - Van der Waals radii from crystals: S. Alvarez, "A cartography of the van der Waals territories", Dalton Transactions
//!   2013, 8617 (doi:10.1039/c3dt50599e).
//! - Colours: those of Jmol (<https://jmol.sourceforge.net/jscolors/>) and the CPK colours of `RasMol`.

use crate::particles::Labels;

/// Radii and colours of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// Symbol, such as `Fe`.
    pub symbol: &'static str,
    /// Covalent radius in angstrom (Cordero).
    pub covalent: Option<f32>,
    /// Van der Waals radius in angstrom (Bondi, Mantina).
    pub van_der_waals: Option<f32>,
    /// Van der Waals radius in angstrom (Alvarez).
    pub alvarez: Option<f32>,
    /// Colour of Jmol: red, green, blue in sRGB.
    pub jmol: [u8; 3],
    /// Colour of `RasMol`'s CPK scheme: red, green, blue in sRGB. Hydrogen is white, unlisted elements are pink or white.
    pub cpk: [u8; 3],
}

/// The number of elements.
pub const COUNT: u8 = 118;

/// An element by its atomic number, 1 to [`COUNT`].
pub fn element(number: u8) -> Option<&'static Element> {
    ELEMENTS.get(usize::from(number).checked_sub(1)?)
}

/// The atomic number of a symbol in any case; deuterium (`D`) and tritium (`T`) are hydrogen.
pub fn by_symbol(symbol: &str) -> Option<u8> {
    if matches!(symbol, "D" | "T") {
        return Some(1);
    }
    if !(1..=2).contains(&symbol.len()) {
        return None;
    }
    let index = ELEMENTS.iter().position(|element| element.symbol.eq_ignore_ascii_case(symbol))?;
    Some(index as u8 + 1)
}

/// The atomic number of a symbol or of an atomic number; 0 if it is neither.
pub(crate) fn element_of(text: &str) -> u8 {
    let by_number = || text.parse().ok().filter(|&number| element(number).is_some());
    by_symbol(text).or_else(by_number).unwrap_or(0)
}

/// The atomic numbers of a column of labels, unless none is known.
pub(crate) fn elements_of(labels: &Labels, of: impl Fn(&str) -> u8) -> Option<Vec<u8>> {
    let numbers: Vec<u8> = labels.names.iter().map(|name| of(name)).collect();
    let is_known = numbers.iter().any(|&number| number > 0);
    is_known.then(|| labels.index.iter().map(|&index| numbers[usize::from(index)]).collect())
}

static ELEMENTS: [Element; COUNT as usize] = {
    let mut all = [from_row(&ROWS[0]); COUNT as usize];
    let mut index = 0;
    while index < all.len() {
        all[index] = from_row(&ROWS[index]);
        index += 1;
    }
    all
};

/// Symbol; covalent, van der Waals and Alvarez radius, 0 where the source has none; colours of Jmol and CPK.
type Row = (&'static str, f32, f32, f32, u32, u32);

const fn from_row(&(symbol, covalent, van_der_waals, alvarez, jmol, cpk): &Row) -> Element {
    Element {
        symbol,
        covalent: known(covalent),
        van_der_waals: known(van_der_waals),
        alvarez: known(alvarez),
        jmol: rgb(jmol),
        cpk: rgb(cpk),
    }
}

const fn known(radius: f32) -> Option<f32> {
    if radius > 0.0 { Some(radius) } else { None }
}

const fn rgb(color: u32) -> [u8; 3] {
    [(color >> 16) as u8, (color >> 8) as u8, color as u8]
}

// Colours are written as everywhere else; rows stay rows.
#[allow(clippy::unreadable_literal)]
#[rustfmt::skip]
const ROWS: [Row; COUNT as usize] = [
    ("H", 0.31, 1.2, 1.2, 0xFFFFFF, 0xFFFFFF),
    ("He", 0.28, 1.4, 1.43, 0xD9FFFF, 0xFFC0CB),
    ("Li", 1.28, 1.82, 2.12, 0xCC80FF, 0xB22222),
    ("Be", 0.96, 1.53, 1.98, 0xC2FF00, 0xFF1493),
    ("B", 0.84, 1.92, 1.91, 0xFFB5B5, 0x00FF00),
    ("C", 0.76, 1.7, 1.77, 0x909090, 0xC8C8C8),
    ("N", 0.71, 1.55, 1.66, 0x3050F8, 0x8F8FFF),
    ("O", 0.66, 1.52, 1.5, 0xFF0D0D, 0xF00000),
    ("F", 0.57, 1.47, 1.46, 0x90E050, 0xDAA520),
    ("Ne", 0.58, 1.54, 1.58, 0xB3E3F5, 0xFF1493),
    ("Na", 1.66, 2.27, 2.5, 0xAB5CF2, 0x0000FF),
    ("Mg", 1.41, 1.73, 2.51, 0x8AFF00, 0x228B22),
    ("Al", 1.21, 1.84, 2.25, 0xBFA6A6, 0x808090),
    ("Si", 1.11, 2.1, 2.19, 0xF0C8A0, 0xDAA520),
    ("P", 1.07, 1.8, 1.9, 0xFF8000, 0xFFA500),
    ("S", 1.05, 1.8, 1.89, 0xFFFF30, 0xFFC832),
    ("Cl", 1.02, 1.75, 1.82, 0x1FF01F, 0x00FF00),
    ("Ar", 1.06, 1.88, 1.83, 0x80D1E3, 0xFF1493),
    ("K", 2.03, 2.75, 2.73, 0x8F40D4, 0xFF1493),
    ("Ca", 1.76, 2.31, 2.62, 0x3DFF00, 0x808090),
    ("Sc", 1.7, 0.0, 2.58, 0xE6E6E6, 0xFF1493),
    ("Ti", 1.6, 0.0, 2.46, 0xBFC2C7, 0x808090),
    ("V", 1.53, 0.0, 2.42, 0xA6A6AB, 0xFF1493),
    ("Cr", 1.39, 0.0, 2.45, 0x8A99C7, 0x808090),
    ("Mn", 1.39, 0.0, 2.45, 0x9C7AC7, 0x808090),
    ("Fe", 1.32, 0.0, 2.44, 0xE06633, 0xFFA500),
    ("Co", 1.26, 0.0, 2.4, 0xF090A0, 0xFF1493),
    ("Ni", 1.24, 1.63, 2.4, 0x50D050, 0xA52A2A),
    ("Cu", 1.32, 1.4, 2.38, 0xC88033, 0xA52A2A),
    ("Zn", 1.22, 1.39, 2.39, 0x7D80B0, 0xA52A2A),
    ("Ga", 1.22, 1.87, 2.32, 0xC28F8F, 0xFF1493),
    ("Ge", 1.2, 2.11, 2.29, 0x668F8F, 0xFF1493),
    ("As", 1.19, 1.85, 1.88, 0xBD80E3, 0xFF1493),
    ("Se", 1.2, 1.9, 1.82, 0xFFA100, 0xFF1493),
    ("Br", 1.2, 1.85, 1.86, 0xA62929, 0xA52A2A),
    ("Kr", 1.16, 2.02, 2.25, 0x5CB8D1, 0xFF1493),
    ("Rb", 2.2, 3.03, 3.21, 0x702EB0, 0xFF1493),
    ("Sr", 1.95, 2.49, 2.84, 0x00FF00, 0xFF1493),
    ("Y", 1.9, 0.0, 2.75, 0x94FFFF, 0xFF1493),
    ("Zr", 1.75, 0.0, 2.52, 0x94E0E0, 0xFF1493),
    ("Nb", 1.64, 0.0, 2.56, 0x73C2C9, 0xFF1493),
    ("Mo", 1.54, 0.0, 2.45, 0x54B5B5, 0xFF1493),
    ("Tc", 1.47, 0.0, 2.44, 0x3B9E9E, 0xFF1493),
    ("Ru", 1.46, 0.0, 2.46, 0x248F8F, 0xFF1493),
    ("Rh", 1.42, 0.0, 2.44, 0x0A7D8C, 0xFF1493),
    ("Pd", 1.39, 1.63, 2.15, 0x006985, 0xFF1493),
    ("Ag", 1.45, 1.72, 2.53, 0xC0C0C0, 0x808090),
    ("Cd", 1.44, 1.58, 2.49, 0xFFD98F, 0xFF1493),
    ("In", 1.42, 1.93, 2.43, 0xA67573, 0xFF1493),
    ("Sn", 1.39, 2.17, 2.42, 0x668080, 0xFF1493),
    ("Sb", 1.39, 2.06, 2.47, 0x9E63B5, 0xFF1493),
    ("Te", 1.38, 2.06, 1.99, 0xD47A00, 0xFF1493),
    ("I", 1.39, 1.98, 2.04, 0x940094, 0xA020F0),
    ("Xe", 1.4, 2.16, 2.06, 0x429EB0, 0xFF1493),
    ("Cs", 2.44, 3.43, 3.48, 0x57178F, 0xFF1493),
    ("Ba", 2.15, 2.49, 3.03, 0x00C900, 0xFFA500),
    ("La", 2.07, 0.0, 2.98, 0x70D4FF, 0xFF1493),
    ("Ce", 2.04, 0.0, 2.88, 0xFFFFC7, 0xFF1493),
    ("Pr", 2.03, 0.0, 2.92, 0xD9FFC7, 0xFF1493),
    ("Nd", 2.01, 0.0, 2.95, 0xC7FFC7, 0xFF1493),
    ("Pm", 1.99, 0.0, 0.0, 0xA3FFC7, 0xFF1493),
    ("Sm", 1.98, 0.0, 2.9, 0x8FFFC7, 0xFF1493),
    ("Eu", 1.98, 0.0, 2.87, 0x61FFC7, 0xFF1493),
    ("Gd", 1.96, 0.0, 2.83, 0x45FFC7, 0xFF1493),
    ("Tb", 1.94, 0.0, 2.79, 0x30FFC7, 0xFF1493),
    ("Dy", 1.92, 0.0, 2.87, 0x1FFFC7, 0xFF1493),
    ("Ho", 1.92, 0.0, 2.81, 0x00FF9C, 0xFF1493),
    ("Er", 1.89, 0.0, 2.83, 0x00E675, 0xFF1493),
    ("Tm", 1.9, 0.0, 2.79, 0x00D452, 0xFF1493),
    ("Yb", 1.87, 0.0, 2.8, 0x00BF38, 0xFF1493),
    ("Lu", 1.87, 0.0, 2.74, 0x00AB24, 0xFF1493),
    ("Hf", 1.75, 0.0, 2.63, 0x4DC2FF, 0xFF1493),
    ("Ta", 1.7, 0.0, 2.53, 0x4DA6FF, 0xFF1493),
    ("W", 1.62, 0.0, 2.57, 0x2194D6, 0xFF1493),
    ("Re", 1.51, 0.0, 2.49, 0x267DAB, 0xFF1493),
    ("Os", 1.44, 0.0, 2.48, 0x266696, 0xFF1493),
    ("Ir", 1.41, 0.0, 2.41, 0x175487, 0xFF1493),
    ("Pt", 1.36, 1.75, 2.29, 0xD0D0E0, 0xFF1493),
    ("Au", 1.36, 1.66, 2.32, 0xFFD123, 0xDAA520),
    ("Hg", 1.32, 1.55, 2.45, 0xB8B8D0, 0xFF1493),
    ("Tl", 1.45, 1.96, 2.47, 0xA6544D, 0xFF1493),
    ("Pb", 1.46, 2.02, 2.6, 0x575961, 0xFF1493),
    ("Bi", 1.48, 2.07, 2.54, 0x9E4FB5, 0xFF1493),
    ("Po", 1.4, 1.97, 0.0, 0xAB5C00, 0xFF1493),
    ("At", 1.5, 2.02, 0.0, 0x754F45, 0xFF1493),
    ("Rn", 1.5, 2.2, 0.0, 0x428296, 0xFFFFFF),
    ("Fr", 2.6, 3.48, 0.0, 0x420066, 0xFFFFFF),
    ("Ra", 2.21, 2.83, 0.0, 0x007D00, 0xFFFFFF),
    ("Ac", 2.15, 0.0, 2.8, 0x70ABFA, 0xFFFFFF),
    ("Th", 2.06, 0.0, 2.93, 0x00BAFF, 0xFF1493),
    ("Pa", 2.0, 0.0, 2.88, 0x00A1FF, 0xFFFFFF),
    ("U", 1.96, 1.86, 2.71, 0x008FFF, 0xFF1493),
    ("Np", 1.9, 0.0, 2.82, 0x0080FF, 0xFFFFFF),
    ("Pu", 1.87, 0.0, 2.81, 0x006BFF, 0xFFFFFF),
    ("Am", 1.8, 0.0, 2.83, 0x545CF2, 0xFFFFFF),
    ("Cm", 1.69, 0.0, 3.05, 0x785CE3, 0xFFFFFF),
    ("Bk", 0.0, 0.0, 3.4, 0x8A4FE3, 0xFFFFFF),
    ("Cf", 0.0, 0.0, 3.05, 0xA136D4, 0xFFFFFF),
    ("Es", 0.0, 0.0, 2.7, 0xB31FD4, 0xFFFFFF),
    ("Fm", 0.0, 0.0, 0.0, 0xB31FBA, 0xFFFFFF),
    ("Md", 0.0, 0.0, 0.0, 0xB30DA6, 0xFFFFFF),
    ("No", 0.0, 0.0, 0.0, 0xBD0D87, 0xFFFFFF),
    ("Lr", 0.0, 0.0, 0.0, 0xC70066, 0xFFFFFF),
    ("Rf", 0.0, 0.0, 0.0, 0xCC0059, 0xFFFFFF),
    ("Db", 0.0, 0.0, 0.0, 0xD1004F, 0xFFFFFF),
    ("Sg", 0.0, 0.0, 0.0, 0xD90045, 0xFFFFFF),
    ("Bh", 0.0, 0.0, 0.0, 0xE00038, 0xFFFFFF),
    ("Hs", 0.0, 0.0, 0.0, 0xE6002E, 0xFFFFFF),
    ("Mt", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Ds", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Rg", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Cn", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Nh", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Fl", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Mc", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Lv", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Ts", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
    ("Og", 0.0, 0.0, 0.0, 0xEB0026, 0xFFFFFF),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_and_numbers_belong_together() {
        for number in 1..=COUNT {
            let symbol = element(number).unwrap().symbol;
            assert_eq!(by_symbol(symbol), Some(number));
            assert_eq!(by_symbol(&symbol.to_uppercase()), Some(number));
        }
        assert_eq!(
            [by_symbol("D"), by_symbol("fe"), by_symbol("X"), by_symbol("")],
            [Some(1), Some(26), None, None]
        );
        assert_eq!([element(0), element(119)], [None, None]);
    }

    /// Values that the sources print, for the first, some common and the last element of each table.
    #[test]
    fn radii_and_colours_are_those_of_the_sources() {
        let carbon = element(6).unwrap();
        assert_eq!(
            (carbon.covalent, carbon.van_der_waals, carbon.alvarez),
            (Some(0.76), Some(1.7), Some(1.77))
        );
        assert_eq!((carbon.jmol, carbon.cpk), ([0x90; 3], [0xc8; 3]));
        let oxygen = element(8).unwrap();
        assert_eq!((oxygen.covalent, oxygen.jmol, oxygen.cpk), (Some(0.66), [255, 13, 13], [240, 0, 0]));
        let iron = element(26).unwrap();
        assert_eq!((iron.covalent, iron.van_der_waals, iron.alvarez), (Some(1.32), None, Some(2.44)));
        assert_eq!(element(96).unwrap().covalent, Some(1.69));
        assert_eq!(element(97).unwrap().covalent, None);
        assert_eq!(element(109).unwrap().jmol, [0xeb, 0, 0x26]);
    }
}
