//! `sppm info` of images that something else has made.

use crate::sandbox::Sandbox;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, Layers, WritableImage,
};
use std::path::Path;

/// An EXR file of 2 x 1 pixels with a layer of each name.
pub(crate) fn write_layers(path: &Path, names: &[&str]) {
    let mut layers = Layers::new();
    for &name in names {
        let channels =
            ["B", "G", "R"].map(|channel| AnyChannel::new(channel, FlatSamples::F32(vec![0.5; 2])));
        let channels = AnyChannels::sort(channels.into_iter().collect());
        layers.push(Layer::new((2, 1), LayerAttributes::named(name), Encoding::UNCOMPRESSED, channels));
    }
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((2, 1)));
    Image::from_layers(attributes, layers).write().to_file(path).unwrap();
}

/// No layer has to be named, as none is read.
#[test]
fn layers_are_listed() {
    let sandbox = Sandbox::new();
    write_layers(&sandbox.path("two.exr"), &["diffuse", "glossy"]);
    let told = sandbox.run(["info", "two.exr"]);
    assert_eq!(told.code, Some(0), "{told:?}");
    for line in ["format     EXR, linear floats", "size       2 x 1 pixels", "layers     diffuse, glossy"] {
        assert!(told.stdout.lines().any(|found| found == line), "{line}: {told:?}");
    }
    let told: serde_json::Value =
        serde_json::from_str(&sandbox.run(["info", "two.exr", "--json"]).stdout).unwrap();
    assert_eq!(told["layers"], serde_json::json!(["diffuse", "glossy"]));
    assert_eq!((&told["width"], &told["height"]), (&2.into(), &1.into()));
}
