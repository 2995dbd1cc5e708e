//! What named columns are, for formats that leave their names to whoever writes them: CSV, PLY, `NumPy`.

use crate::layout::{Kind, Role};

/// The role of the column `name` among columns of these names; all in lower case. `None` for a mere number.
pub(crate) fn role(name: &str, all: &[String]) -> Option<Role> {
    let has = |other: &str| all.iter().any(|name| name == other);
    let is_rgb = ["r", "g", "b"].into_iter().all(has);
    Some(match name {
        "x" | "px" | "pos_x" | "position_x" | "positions_x" | "center_x" | "centre_x" | "points:0"
        | "coordinates:0" => Role::Axis(0),
        "y" | "py" | "pos_y" | "position_y" | "positions_y" | "center_y" | "centre_y" | "points:1"
        | "coordinates:1" => Role::Axis(1),
        "z" | "pz" | "pos_z" | "position_z" | "positions_z" | "center_z" | "centre_z" | "points:2"
        | "coordinates:2" => Role::Axis(2),
        "r" if is_rgb => Role::Color(0),
        "g" if is_rgb => Role::Color(1),
        "b" if is_rgb => Role::Color(2),
        "red" | "color_r" | "diffuse_red" => Role::Color(0),
        "green" | "color_g" | "diffuse_green" => Role::Color(1),
        "blue" | "color_b" | "diffuse_blue" => Role::Color(2),
        "r" | "radius" | "radii" => Role::Radius,
        "diameter" | "diameters" if !["radius", "radii"].into_iter().any(has) && (!has("r") || is_rgb) => {
            Role::Diameter
        }
        "type" | "types" | "kind" => Role::Label(Kind::Type),
        "element" | "elements" | "species" | "symbol" | "symbols" | "atomic_number" | "atomic_numbers"
        | "numbers" => Role::Label(Kind::Element),
        "name" | "names" | "atom_name" => Role::Label(Kind::Name),
        "residue" | "residues" | "resname" => Role::Label(Kind::Residue),
        "chain" | "chains" => Role::Label(Kind::Chain),
        "id" | "ids" => Role::Id,
        "mol" | "molecule" | "molecules" | "molecule_id" => Role::Molecule,
        _ => return None,
    })
}

/// The role of the first of a column's components, if `name` has as many as such a role needs: `pos` has three.
pub(crate) fn role_of_vector(name: &str, components: usize) -> Option<Role> {
    match (name, components) {
        (
            "pos" | "position" | "positions" | "xyz" | "points" | "center" | "centers" | "centre" | "centres"
            | "coordinates" | "coords",
            3,
        ) => Some(Role::Axis(0)),
        ("color" | "colors" | "colour" | "colours" | "rgb", 3) | ("rgba" | "color" | "colors", 4) => {
            Some(Role::Color(0))
        }
        _ => None,
    }
}

/// The message for columns without coordinates.
pub(crate) fn no_axes(names: &[String]) -> String {
    let shown: Vec<&str> = names.iter().take(12).map(String::as_str).collect();
    let more = if names.len() > shown.len() { ", ..." } else { "" };
    format!("has no columns x, y and z; its columns are {}{more}", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn r_is_a_radius_unless_it_is_red() {
        let of = |names: &str| {
            let names: Vec<String> = names.split(' ').map(str::to_owned).collect();
            names.iter().map(|name| role(name, &names)).collect::<Vec<_>>()
        };
        assert_eq!(of("x r q"), [Some(Role::Axis(0)), Some(Role::Radius), None]);
        assert_eq!(
            of("r g b radius")[..],
            [Role::Color(0), Role::Color(1), Role::Color(2), Role::Radius].map(Some)
        );
        assert_eq!(of("radius diameter"), [Some(Role::Radius), None], "one of the two is enough");
        assert_eq!(of("diameter"), [Some(Role::Diameter)]);
    }

    /// As programs call them: each name of a coordinate is that of its axis, and those of labels are what they say.
    #[test]
    fn columns_are_what_their_names_say() {
        let of = |name: &str| role(name, &[name.to_owned()]);
        for prefix in ["", "p", "pos_", "position_", "positions_", "center_", "centre_"] {
            let found = ["x", "y", "z"].map(|axis| of(&format!("{prefix}{axis}")));
            assert_eq!(found, [0, 1, 2].map(|axis| Some(Role::Axis(axis))), "{prefix}");
        }
        for prefix in ["points:", "coordinates:"] {
            let found = [0, 1, 2].map(|axis| of(&format!("{prefix}{axis}")));
            assert_eq!(found, [0, 1, 2].map(|axis| Some(Role::Axis(axis))), "{prefix}");
        }
        for names in [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"]] {
            assert_eq!(names.map(of), [0, 1, 2].map(|channel| Some(Role::Color(channel))), "{names:?}");
        }
        for (name, kind) in [
            ("atom_name", Kind::Name),
            ("resname", Kind::Residue),
            ("residue", Kind::Residue),
            ("chain", Kind::Chain),
            ("species", Kind::Element),
            ("atomic_numbers", Kind::Element),
            ("kind", Kind::Type),
        ] {
            assert_eq!(of(name), Some(Role::Label(kind)), "{name}");
        }
        assert_eq!(
            [of("mol"), of("molecule_id"), of("id")],
            [Role::Molecule, Role::Molecule, Role::Id].map(Some)
        );
        let vector = role_of_vector;
        assert_eq!([vector("pos", 3), vector("centers", 3)], [Some(Role::Axis(0)); 2]);
        assert_eq!([vector("rgb", 3), vector("rgba", 4), vector("color", 4)], [Some(Role::Color(0)); 3]);
        assert_eq!([vector("pos", 2), vector("pos", 4), vector("rgb", 4), vector("forces", 3)], [None; 4]);
    }
}
