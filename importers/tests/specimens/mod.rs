//! A small file of each format, made here.

use flate2::Compression;
use flate2::write::{DeflateEncoder, GzEncoder};
use importers::Format;
use std::fmt::Write as _;
use std::io::Write as _;

/// Particles of each specimen.
pub(crate) const COUNT: usize = 300;

/// A file in memory.
pub(crate) struct Specimen {
    pub(crate) name: &'static str,
    pub(crate) format: Format,
    pub(crate) bytes: Vec<u8>,
}

/// One of each format, and several of those with variants.
pub(crate) fn specimens() -> Vec<Specimen> {
    let of = |name, format, bytes: Vec<u8>| Specimen { name, format, bytes };
    vec![
        of("xyz", Format::Xyz, xyz().into_bytes()),
        of("extended xyz", Format::Xyz, extended_xyz(3).into_bytes()),
        of("xyz.gz", Format::Xyz, gzip(xyz().as_bytes())),
        of("pdb", Format::Pdb, pdb().into_bytes()),
        of("mmcif", Format::Mmcif, mmcif().into_bytes()),
        of("crystal", Format::Mmcif, crystal().into_bytes()),
        of("gro", Format::Gro, gro().into_bytes()),
        of("dump", Format::Dump, dump("x y z", "").into_bytes()),
        of("scaled dump", Format::Dump, dump("xs ys zs", " xy xz yz").into_bytes()),
        of("gsd", Format::Gsd, gsd()),
        of("ascii ply", Format::Ply, ply("ascii")),
        of("little ply", Format::Ply, ply("binary_little_endian")),
        of("big ply", Format::Ply, ply("binary_big_endian")),
        of("csv", Format::Csv, csv(',').into_bytes()),
        of("npy", Format::Npy, npy("'<f8'", &format!("({COUNT}, 3)"), false, &floats(3))),
        of(
            "fortran npy",
            Format::Npy,
            npy("'<f8'", &format!("({COUNT}, 4)"), true, &by_columns(&floats(4), 4)),
        ),
        of("structured npy", Format::Npy, structured_npy()),
        of("npz", Format::Npz, npz(false)),
        of("compressed npz", Format::Npz, npz(true)),
    ]
}

/// The position of a particle.
pub(crate) fn place(at: usize) -> [f64; 3] {
    [0.25 * (at % 7) as f64, 0.5 * (at / 7 % 11) as f64, 0.125 * at as f64]
}

fn symbol(at: usize) -> &'static str {
    ["O", "H", "H", "Na", "Cl"][at % 5]
}

pub(crate) fn xyz() -> String {
    let mut text = format!("{COUNT}\nsalty water\n");
    for at in 0..COUNT {
        let [x, y, z] = place(at);
        let _ = writeln!(text, "{} {x:.4} {y:.4} {z:.4}", symbol(at));
    }
    text
}

pub(crate) fn extended_xyz(frames: usize) -> String {
    let mut text = String::new();
    for frame in 0..frames {
        let _ = writeln!(
            text,
            "{COUNT}\nLattice=\"2 0 0 1 6 0 0 0 40\" Properties=species:S:1:pos:R:3:radius:R:1:color:R:3:id:I:1:q:R:1:fixed:L:1 \
             pbc=\"T T F\" note=\"a \\\"quoted\\\" text\" time={frame}"
        );
        for at in 0..COUNT {
            let [x, y, z] = place(at);
            let x = x + frame as f64;
            let _ = writeln!(
                text,
                "{} {x} {y} {z} 0.{} 0.1 0.2 0.3 {} -1.5e-3 T",
                symbol(at),
                at % 9 + 1,
                COUNT - at
            );
        }
    }
    text
}

pub(crate) fn pdb() -> String {
    let mut text = String::from(
        "TITLE     SALTY WATER\nCRYST1   20.000   30.000   40.000  90.00 100.00  90.00 P 1           1\n",
    );
    for model in 1..3 {
        let _ = writeln!(text, "MODEL     {model:>4}");
        for at in 0..COUNT {
            let [x, y, z] = place(at);
            let mark = [' ', 'A', 'B'][at % 3];
            let _ = writeln!(
                text,
                "HETATM{:>5} {:<4}{mark}{:<3} W{:>4}    {x:>8.3}{y:>8.3}{z:>8.3}  0.50 10.00          {:>2}",
                at + 1,
                ["  O ", " H1 ", " H1 "][at % 3],
                "HOH",
                at / 3,
                symbol(at)
            );
        }
        text.push_str("ENDMDL\n");
    }
    text.push_str("CONECT    1    2    3\nCONECT    4    5\nEND\n");
    text
}

pub(crate) fn mmcif() -> String {
    let mut text = String::from(
        "data_WATER\n# a comment\n_struct.title 'salty water'\n_cell.length_a 20\n_cell.length_b 30\n_cell.length_c 40\n\
         _cell.angle_alpha 90\n_cell.angle_beta 100\n_cell.angle_gamma 90\n_note.text\n;several\nlines\n;\nloop_\n\
         _struct_conn.conn_type_id\n_struct_conn.ptnr1_auth_asym_id\n_struct_conn.ptnr1_auth_seq_id\n\
         _struct_conn.ptnr1_label_atom_id\n_struct_conn.ptnr2_auth_asym_id\n_struct_conn.ptnr2_auth_seq_id\n\
         _struct_conn.ptnr2_label_atom_id\ncovale W 0 O W 0 H1\nhydrog W 1 O W 1 H1\nloop_\n_atom_site.group_PDB\n\
         _atom_site.id\n_atom_site.type_symbol\n_atom_site.label_atom_id\n_atom_site.label_alt_id\n_atom_site.label_comp_id\n\
         _atom_site.auth_asym_id\n_atom_site.auth_seq_id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n\
         _atom_site.occupancy\n_atom_site.B_iso_or_equiv\n_atom_site.pdbx_PDB_model_num\n",
    );
    for model in 1..3 {
        for at in 0..COUNT {
            let [x, y, z] = place(at);
            let (name, mark) = (["O", "H1", "\"H2'\""][at % 3], [".", "A", "B"][at % 3]);
            let _ = writeln!(
                text,
                "HETATM {} {} {name} {mark} HOH W {} {x} {y} {z} 0.5 10.0 {model}",
                at + 1,
                symbol(at),
                at / 3
            );
        }
    }
    text
}

pub(crate) fn crystal() -> String {
    let mut text = String::from(
        "data_SALT\n_cell_length_a 5.64(1)\n_cell_length_b 5.64(1)\n_cell_length_c 5.64(1)\nloop_\n\
         _symmetry_equiv_pos_as_xyz\nx,y,z\n'-x, -y, z+1/2'\n-z,x-y,y\nloop_\n_atom_site_label\n_atom_site_type_symbol\n\
         _atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\n",
    );
    for at in 0..COUNT / 3 {
        let _ = writeln!(text, "Na{at} Na+ 0.{at:03}(2) 0.{:03} 0.777", 7 * at % 1000);
    }
    text
}

pub(crate) fn gro() -> String {
    let mut text = format!("salty water t= 1.0\n{COUNT:>5}\n");
    for at in 0..COUNT {
        let [x, y, z] = place(at).map(|number| 0.1 * number);
        let _ = writeln!(
            text,
            "{:>5}{:<5}{:>5}{:>5}{x:>8.3}{y:>8.3}{z:>8.3}  0.1000  0.2000 -0.3000",
            at / 3,
            "SOL",
            ["OW", "HW1", "HW2"][at % 3],
            (at + 99_900) % 100_000
        );
    }
    text.push_str(
        "   2.00000   3.00000   4.00000   0.00000   0.00000   0.10000   0.00000   0.20000   0.30000\n",
    );
    text
}

pub(crate) fn dump(axes: &str, tilt: &str) -> String {
    let mut text = String::new();
    for frame in 0..2 {
        let _ = writeln!(
            text,
            "ITEM: UNITS\nmetal\nITEM: TIMESTEP\n{frame}\nITEM: NUMBER OF ATOMS\n{COUNT}\nITEM: BOX BOUNDS{tilt} pp pp ff"
        );
        for axis in 0..3 {
            let _ =
                writeln!(text, "{} {}{}", -axis, 10 * (axis + 1), if tilt.is_empty() { "" } else { " 0.5" });
        }
        let _ = writeln!(text, "ITEM: ATOMS id type {axes} radius mol q ");
        for at in 0..COUNT {
            let id = at * 7 % COUNT;
            let [x, y, z] = place(id);
            let _ = writeln!(text, "{} {} {x} {y} {z} 0.5 {} 1.5e-3 ", id + 1, id % 3 + 1, id / 3);
        }
    }
    text
}

pub(crate) fn csv(separator: char) -> String {
    let mut text =
        "x,y,z,radius,element,\"a note\",charge,red,green,blue\n".replace(',', &separator.to_string());
    for at in 0..COUNT {
        let [x, y, z] = place(at);
        let note = if at % 10 == 0 { "\"in \"\"quotes\"\"\"" } else { "plain" };
        let line = format!("{x},{y},{z},0.5,{},{note},-0.25,255,{},0\n", symbol(at), at % 256);
        text.push_str(&line.replace(',', &separator.to_string()));
    }
    text
}

pub(crate) fn ply(encoding: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\ncomment salty water\nelement vertex {COUNT}\nproperty float x\nproperty float y\nproperty double z\n\
         property float radius\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty short q\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for at in 0..COUNT {
        let [x, y, z] = place(at);
        let (x, y) = (x as f32, y as f32);
        if encoding == "ascii" {
            bytes.extend_from_slice(format!("{x} {y} {z} 0.5 255 {} 0 -7\n", at % 256).as_bytes());
            continue;
        }
        let is_big = encoding == "binary_big_endian";
        let mut put = |mut number: Vec<u8>| {
            if is_big {
                number.reverse();
            }
            bytes.extend(number);
        };
        for number in [x, y] {
            put(number.to_le_bytes().to_vec());
        }
        put(z.to_le_bytes().to_vec());
        put(0.5_f32.to_le_bytes().to_vec());
        for byte in [255, (at % 256) as u8, 0] {
            put(vec![byte]);
        }
        put((-7_i16).to_le_bytes().to_vec());
    }
    bytes.extend_from_slice(if encoding == "ascii" { b"3 0 1 2\n" } else { &[0] });
    bytes
}

/// Rows of `width` numbers: positions and radii.
pub(crate) fn floats(width: usize) -> Vec<u8> {
    let numbers = (0..COUNT).flat_map(|at| place(at).into_iter().chain([0.5]).take(width));
    numbers.flat_map(f64::to_le_bytes).collect()
}

/// The same numbers, column after column.
pub(crate) fn by_columns(rows: &[u8], width: usize) -> Vec<u8> {
    let column = |at: usize| rows.chunks_exact(8).skip(at).step_by(width).flatten().copied();
    (0..width).flat_map(column).collect()
}

pub(crate) fn npy(descr: &str, shape: &str, is_fortran: bool, data: &[u8]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let mut header = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}");
    while (header.len() + 11) % 64 > 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn structured_npy() -> Vec<u8> {
    let mut data = Vec::new();
    for at in 0..COUNT {
        data.push(0);
        data.extend(place(at).into_iter().flat_map(|number| (number as f32).to_le_bytes()));
        data.extend(format!("{:\0<2}", symbol(at)).bytes().flat_map(|byte| u32::from(byte).to_le_bytes()));
        data.extend(0.25_f64.to_le_bytes());
    }
    let descr = "[('', '|V1'), ('pos', '<f4', (3,)), ('species', '<U2'), ('q', '<f8')]";
    npy(descr, &format!("({COUNT},)"), false, &data)
}

fn npz(is_compressed: bool) -> Vec<u8> {
    let radii: Vec<u8> = (0..COUNT).flat_map(|_| 0.5_f32.to_le_bytes()).collect();
    let types: Vec<u8> = (0..COUNT).flat_map(|at| ((at % 3) as i64).to_le_bytes()).collect();
    let cell: Vec<u8> = [4.0_f64, 5.0, 60.0].into_iter().flat_map(f64::to_le_bytes).collect();
    let arrays = [
        ("positions.npy", npy("'<f8'", &format!("({COUNT}, 3)"), false, &floats(3))),
        ("radii.npy", npy("'<f4'", &format!("({COUNT},)"), false, &radii)),
        ("types.npy", npy("'<i8'", &format!("({COUNT},)"), false, &types)),
        ("cell.npy", npy("'<f8'", "(3,)", false, &cell)),
    ];
    zip(&arrays, is_compressed)
}

pub(crate) fn zip(files: &[(&str, Vec<u8>)], is_compressed: bool) -> Vec<u8> {
    use rawzip::{CompressionMethod, ZipArchiveWriter};
    let mut bytes = Vec::new();
    let mut archive = ZipArchiveWriter::new(&mut bytes);
    for (name, data) in files {
        let method = if is_compressed { CompressionMethod::DEFLATE } else { CompressionMethod::STORE };
        let (mut entry, config) = archive.new_file(name).compression_method(method).start().unwrap();
        let descriptor = if is_compressed {
            let mut writer = config.wrap(DeflateEncoder::new(&mut entry, Compression::default()));
            writer.write_all(data).unwrap();
            let (encoder, descriptor) = writer.finish().unwrap();
            encoder.finish().unwrap();
            descriptor
        } else {
            let mut writer = config.wrap(&mut entry);
            writer.write_all(data).unwrap();
            writer.finish().unwrap().1
        };
        entry.finish(descriptor).unwrap();
    }
    archive.finish().unwrap();
    bytes
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A chunk of a GSD file: frame, name, kind of its numbers, columns and bytes.
pub(crate) type Chunk<'a> = (u64, &'a str, u8, u32, Vec<u8>);

/// Two frames, of which the second has its own positions alone.
pub(crate) fn gsd() -> Vec<u8> {
    let floats = |numbers: Vec<f32>| numbers.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    let positions = |shift: f32| {
        floats((0..COUNT).flat_map(|at| place(at).map(|number| number as f32 + shift)).collect())
    };
    let kinds = (0..COUNT).flat_map(|at| ((at % 2) as u32).to_le_bytes()).collect();
    gsd_of(&[
        (0, "particles/N", 3, 1, (COUNT as u32).to_le_bytes().to_vec()),
        (0, "configuration/box", 9, 1, floats(vec![100.0, 100.0, 100.0, 0.1, 0.2, 0.3])),
        (0, "particles/types", 5, 6, b"first\0other\0".to_vec()),
        (0, "particles/typeid", 3, 1, kinds),
        (0, "particles/position", 9, 3, positions(0.0)),
        (0, "particles/charge", 9, 1, floats(vec![0.5; COUNT])),
        (0, "bonds/N", 3, 1, 2_u32.to_le_bytes().to_vec()),
        (0, "bonds/group", 3, 2, [1_u32, 0, 2, 3].into_iter().flat_map(u32::to_le_bytes).collect()),
        (1, "particles/position", 9, 3, positions(1.0)),
    ])
}

pub(crate) fn gsd_of(chunks: &[Chunk]) -> Vec<u8> {
    const SIZES: [usize; 12] = [0, 1, 2, 4, 8, 1, 2, 4, 8, 4, 8, 1];
    let (mut data, mut index, mut names) = (Vec::new(), Vec::new(), Vec::<&str>::new());
    for (frame, name, kind, columns, bytes) in chunks {
        let id = names.iter().position(|known| known == name).unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        });
        let rows = bytes.len() / SIZES[usize::from(*kind)] / *columns as usize;
        index.extend(frame.to_le_bytes());
        index.extend((rows as u64).to_le_bytes());
        index.extend((256 + data.len() as u64).to_le_bytes());
        index.extend(columns.to_le_bytes());
        index.extend((id as u16).to_le_bytes());
        index.extend([*kind, 0]);
        data.extend(bytes);
    }
    index.extend([0; 32]);
    let mut list: Vec<u8> = names.iter().flat_map(|name| name.bytes().chain([0])).collect();
    list.resize(list.len().next_multiple_of(64), 0);
    let (index_at, list_at) = (256 + data.len() as u64, 256 + (data.len() + index.len()) as u64);
    let mut header = Vec::new();
    for word in [0x65DF_65DF_65DF_65DF, index_at, index.len() as u64 / 32, list_at, list.len() as u64 / 64] {
        header.extend(u64::to_le_bytes(word));
    }
    header.extend((1_u32 << 16 | 4).to_le_bytes());
    header.extend((2_u32 << 16).to_le_bytes());
    header.extend([0; 64]);
    header.extend(b"hoomd");
    header.resize(256, 0);
    [header, data, index, list].concat()
}
