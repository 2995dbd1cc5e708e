//! Tables of columns: PLY, CSV.

use super::{all, fault, parse};
use crate::specimens::{self, COUNT};
use importers::{Format, Frame, Properties, Request, read_from};
use std::io::Cursor;

#[test]
fn ply_lists_and_elements_before_the_points_are_skipped() {
    let header = "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int v\nelement vertex 2\nproperty list int float more\n\
                  property float x\nproperty float y\nproperty float z\nproperty float q\nend_header\n";
    let particles = parse(Format::Ply, format!("{header}3 0 1 2\n0\n2 8 9 1 2 3 4\n0 5 6 7 8\n"));
    assert_eq!(
        (particles.positions, particles.properties[0].values.clone()),
        (vec![[1.0, 2.0, 3.0], [5.0, 6.0, 7.0]], vec![4.0, 8.0])
    );
    let mut bytes = header.replace("ascii", "binary_big_endian").into_bytes();
    bytes.extend([1, 0, 0, 0, 7, 0]);
    for (list, numbers) in [(&[8.0_f32, 9.0][..], [1.0_f32, 2.0, 3.0, 4.0]), (&[], [5.0, 6.0, 7.0, 8.0])] {
        bytes.extend((list.len() as i32).to_be_bytes());
        list.iter().chain(&numbers).for_each(|number| bytes.extend(number.to_be_bytes()));
    }
    let particles = parse(Format::Ply, &bytes);
    assert_eq!(particles.positions, [[1.0, 2.0, 3.0], [5.0, 6.0, 7.0]]);
    let fault = |text: &str| fault(Format::Ply, text);
    assert!(fault(&header.replace("vertex", "point")).contains("no element called vertex"));
    assert!(fault(&header.replace("float z", "float w")).contains("has no columns x, y and z"));
    assert!(
        fault(&header.replace("property float x", "property quad x"))
            .starts_with(":7: \"property quad x\" is no line")
    );
    assert!(fault("ply\nformat ascii 1.0\nelement vertex 1\n").contains("where end_header should be"));
    assert!(fault(&header.replace("vertex 2", "vertex 99999999")).contains("is too short for the 99999999"));
}

#[test]
fn colours_are_scaled_by_their_type() {
    let ply = parse(Format::Ply, specimens::ply("ascii")).colors.unwrap();
    assert_eq!((ply[0], ply[51]), ([1.0, 0.0, 0.0], [1.0, 0.2, 0.0]));
    let csv = parse(Format::Csv, "x,y,z,r,g,b\n0,0,0,51,255,0\n").colors.unwrap();
    assert_eq!(csv, [[0.2, 1.0, 0.0]]);
    let csv = parse(Format::Csv, "x,y,z,r,g,b\n0,0,0,0.25,1,0\n").colors.unwrap();
    assert_eq!(csv, [[0.25, 1.0, 0.0]]);
}

/// Wherever they stand; and a column keeps its name as it is written.
#[test]
fn comments_and_blank_lines_of_tables_are_no_particles() {
    for separator in [",", ";", "\t", " "] {
        let text = "x,y,z,Charge\n# written, as it were, by hand\n\n1,2,3,0.5\n\n#4,5,6,7\n4,5,6,-1\n   \n"
            .replace(',', separator);
        let particles = parse(Format::Csv, &text);
        assert_eq!(particles.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{separator:?}");
        assert_eq!(particles.available, ["Charge"]);
        assert_eq!(particles.property("Charge"), Some(&[0.5, -1.0][..]));
    }
}

/// What is missing is no number, rather than 0. Ids that are texts, as tables of other programs have them, are left out.
#[test]
fn fields_of_tables_may_be_missing_or_truths() {
    let text =
        "x,y,z,id,q,fixed\n1,2,3,a7,0.5,1\n4,5,6,b2,,False\n7,8,9,7,NA,T\n1,1,1,,?,F\n1,1,1,x,.,true\n";
    let particles = parse(Format::Csv, text);
    assert_eq!((particles.len(), &particles.ids), (5, &None));
    assert_eq!(particles.property("fixed"), Some(&[1.0, 0.0, 1.0, 0.0, 1.0][..]));
    let q = particles.property("q").unwrap();
    assert!(q[0] == 0.5 && q[1..].iter().all(|value| value.is_nan()), "{q:?}");
}

/// The first row tells which columns are numbers. One that is asked for by its name is, though its first number is missing.
#[test]
fn the_first_field_of_a_column_may_be_a_truth_or_missing() {
    let text = "x,y,z,fixed,q,note,kind\n1,2,3,True,NA,?,F\n4,5,6,False,0.5,words,C\n";
    let read = |properties: Properties| {
        let request = Request { properties, ..all(Frame::Number(0)) };
        read_from("a", Cursor::new(text), Format::Csv, &request).unwrap()
    };
    let particles = read(Properties::All);
    assert_eq!(particles.available, ["fixed"]);
    assert_eq!(particles.property("fixed"), Some(&[1.0, 0.0][..]));
    let q = read(Properties::Named(vec!["q".into()])).property("q").unwrap().to_vec();
    assert!(q[0].is_nan() && q[1] == 0.5, "{q:?}");
}

#[test]
fn tables_of_all_separators_are_read() {
    for separator in [',', ';', '\t'] {
        let particles = parse(Format::Csv, specimens::csv(separator));
        assert_eq!((particles.len(), particles.available.as_slice()), (COUNT, &["charge".to_owned()][..]));
        assert_eq!(particles.elements.unwrap()[..2], [8, 1]);
    }
    let particles = parse(Format::Csv, "X [nm];Y [nm];Z [nm];Radius\n\n1,5;2;-3;\"0,5\"\n");
    assert_eq!((particles.positions, particles.radii), (vec![[1.5, 2.0, -3.0]], Some(vec![0.5])));
    let round = parse(Format::Csv, "x (nm),y (nm),z (nm),charge (e)\n1,2,3,4\n");
    assert_eq!((round.positions, round.available), (vec![[1.0, 2.0, 3.0]], vec!["charge".to_owned()]));
    let particles = parse(Format::Csv, "# x y z id q\n1 2 3 7 nan\n");
    assert_eq!((particles.ids, particles.properties[0].values[0].is_nan()), (Some(vec![7]), true));
    // Blanks beside a separator are no part of a field, whether or not others of its line are in quotation marks.
    let spaced = parse(Format::Csv, "x , y,z , \"name\"\n 1 ,2 , 3,\"O\"\n\"4\" , 5 ,6 , \"O\" \n");
    assert_eq!(spaced.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    // Some programs end each line with a separator; what is empty there is no field.
    for text in ["x,y,z\n1,2,3,\n4,5,6\n", "x;y;z\n1;2;3;\n4;5;6; \n", "x\ty\tz\n1\t2\t3\t\n\"4\"\t5\t6\t\n"]
    {
        assert_eq!(parse(Format::Csv, text).positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{text}");
    }
    let fault = |text: &str| fault(Format::Csv, text);
    assert_eq!(fault("x,y\n1,2\n"), ":1: has no columns x, y and z; its columns are x, y");
    assert!(
        fault("1,2,3\n4,5,6\n").starts_with(":1: the first line has numbers; it should name the columns")
    );
    assert_eq!(
        fault("x,y,z\n1,2,3\n1,,3\n"),
        ":3:1: column y: \"\" is no number; a coordinate is one, such as 1.5"
    );
    assert_eq!(fault("x,y,z\n1,2\n"), ":2:1: the line has 2 of 3 fields; the next is z");
    assert!(fault("x,y,z\n1,2,3,4\n").contains("\"4\" is beyond the 3 columns"));
    assert!(fault("x,y,z,r\n1,2,3,-1\n").contains("column r: the radius is -1"));
}
