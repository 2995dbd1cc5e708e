//! Image files, to look at and to compare with.

use crate::client::{Page, get, project};
use files::image_file::{self, Encoding};
use scene::{Film, Rgb};
use serde_json::json;
use std::path::{Path, PathBuf};
use view::{HEADER, Place, View};

/// An image of this size in `folder`, and its path.
fn image(folder: &Path, name: &str, width: u32, height: u32) -> PathBuf {
    let path = folder.join(name);
    let film = Film::from_fn(width, height, |x, y| Rgb::new(x as f32, y as f32, 1.0));
    image_file::write(&path, &film, &Encoding::default()).unwrap();
    path
}

/// The size that the picture `bytes` has.
fn size(bytes: &[u8]) -> [u32; 2] {
    [12, 16].map(|at| u32::from_le_bytes(bytes[at..][..4].try_into().unwrap()))
}

#[test]
fn an_image_is_shown_with_the_one_to_compare_and_nothing_can_be_changed() {
    let folder = tempfile::tempdir().unwrap();
    let (one, other) = (image(folder.path(), "one.pfm", 4, 3), image(folder.path(), "other.pfm", 6, 5));
    let view = View::files(&one, None, Some(&other), &Place::default()).unwrap();
    let mut page = Page::open(&view);
    let shown = json!({ "type": "scene", "mode": "files", "name": "one.pfm", "layers": ["image"], "others": ["other.pfm"] });
    assert_eq!(page.typed("scene"), shown);
    let picture = page.picture(|_| true);
    assert_eq!((picture.size, picture.whole, picture.layer), ([4, 3], [4, 3], 0));
    let reply = get(&view, "other/0");
    assert_eq!((reply.status, size(&reply.body), reply.body.len()), (200, [6, 5], HEADER + 4 * 30));
    assert_eq!(get(&view, "other/1").status, 404);
    page.send(&json!({ "type": "undo" }));
    assert_eq!(page.typed("refused")["problem"], "nothing can be changed here");
    let missing = folder.path().join("missing.pfm");
    for (one, other) in [(&missing, &other), (&one, &missing)] {
        let problem = View::files(one, None, Some(other), &Place::default()).unwrap_err();
        assert!(problem.contains("missing.pfm") && !problem.contains('\n'), "{problem}");
    }
}

/// The image to compare a scene with may have any size.
#[test]
fn a_scene_is_edited_beside_its_reference() {
    let folder = tempfile::tempdir().unwrap();
    let reference = image(folder.path(), "photo.pfm", 5, 2);
    let view = View::studio(project(), Some(&reference), None, &Place::default()).unwrap();
    let mut page = Page::open(&view);
    assert_eq!(page.typed("scene")["others"], json!(["photo.pfm"]));
    let reply = get(&view, "other/0");
    assert_eq!((reply.status, size(&reply.body)), (200, [5, 2]));
    // Changes leave it there.
    page.send(&json!({ "type": "sphere", "index": 6, "radius": 12.5 }));
    assert_eq!(page.typed("scene")["others"], json!(["photo.pfm"]));
}
