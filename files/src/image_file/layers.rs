//! The layers of an EXR file: pictures among its channels.
//!
//! A file has headers ("parts"), which may have names, and each has channels such as `R` or `diffuse.R`. A layer is the
//! channels of a header that share what stands before the last dot. It can be read if these are R, G and B, or Y, in
//! upper or lower case, or a single channel of any name.

use exr::meta::attribute::ChannelDescription;
use exr::meta::header::Header;
use exr::prelude::Vec2;
use std::collections::BTreeMap;

/// A layer that can be read.
pub(super) struct Layer {
    /// What `--layer` calls it; empty if neither its header nor its channels say.
    name: String,
    /// The number of its header.
    pub(super) header: usize,
    /// The numbers of the channels for red, green and blue; the same thrice for grey.
    pub(super) channels: [usize; 3],
}

impl Layer {
    fn is_colour(&self) -> bool {
        self.channels[0] != self.channels[1]
    }
}

/// The layer called `wanted`; without a name, the only one, the only one in colour, or the one without a name.
pub(super) fn choose(headers: &[Header], wanted: Option<&str>) -> Result<Layer, String> {
    let mut all = all(headers);
    if let Some(wanted) = wanted {
        let listed = listed(&all);
        let place = all.iter().position(|layer| layer.name == wanted).ok_or_else(|| {
            let wanted = shown(wanted);
            match listed.as_str() {
                "" => format!("has no layer `{wanted}`, and none with a name that can be read"),
                listed => format!("has no layer `{wanted}`; it has {listed}"),
            }
        })?;
        return whole(headers, all.swap_remove(place));
    }
    if all.is_empty() {
        return Err(refusal(headers));
    }
    let listed = listed(&all);
    let has_colour = all.iter().any(Layer::is_colour);
    all.retain(|layer| !has_colour || layer.is_colour());
    if all.len() > 1 && all.iter().any(|layer| layer.name.is_empty()) {
        all.retain(|layer| layer.name.is_empty());
    }
    match (all.pop(), all.is_empty()) {
        (Some(layer), true) => whole(headers, layer),
        _ => Err(format!("has several layers; choose one by its name: {listed}")),
    }
}

/// The name of the layer that is read if none is chosen; `None` if one must be chosen.
pub(super) fn usual(headers: &[Header]) -> Option<String> {
    choose(headers, None).ok().map(|layer| layer.name)
}

/// The names of the layers that can be read and have one.
pub(super) fn names(headers: &[Header]) -> Vec<String> {
    all(headers).into_iter().map(|layer| layer.name).filter(|name| !name.is_empty()).collect()
}

/// All layers that can be read.
fn all(headers: &[Header]) -> Vec<Layer> {
    headers.iter().enumerate().flat_map(|(number, header)| layers_of(number, header)).collect()
}

fn layers_of(number: usize, header: &Header) -> Vec<Layer> {
    let list = &header.channels.list;
    let mut groups: BTreeMap<String, Vec<(usize, String)>> = BTreeMap::new();
    for (index, channel) in list.iter().enumerate() {
        let name = channel.name.to_string();
        let (layer, own) = name.rsplit_once('.').unwrap_or(("", &name));
        groups.entry(layer.to_owned()).or_default().push((index, own.to_owned()));
    }
    let part = header.own_attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
    let layers = groups.into_iter().filter_map(|(group, channels)| {
        // Some programs repeat the header's name in each channel.
        let name = match (part.as_str(), group.as_str()) {
            (part, group) if part.is_empty() || part == group => group.to_owned(),
            (part, "") => part.to_owned(),
            (part, group) => format!("{part}.{group}"),
        };
        Some(Layer { name, header: number, channels: picture(&channels)? })
    });
    layers.collect()
}

/// The numbers of the channels that make a picture: red, green and blue; or grey.
fn picture(channels: &[(usize, String)]) -> Option<[usize; 3]> {
    let find = |wanted: &str| {
        let exact = channels.iter().find(|(_, name)| name == wanted);
        exact.or_else(|| channels.iter().find(|(_, name)| name.eq_ignore_ascii_case(wanted))).map(|(i, _)| *i)
    };
    if let (Some(red), Some(green), Some(blue)) = (find("R"), find("G"), find("B")) {
        return Some([red, green, blue]);
    }
    // Y beside RY and BY is not grey, and beside X and Z it is a coordinate.
    let is_grey = ["RY", "BY", "X", "Z"].into_iter().all(|other| find(other).is_none());
    match (find("Y").filter(|_| is_grey), channels) {
        (Some(grey), _) | (None, &[(grey, _)]) => Some([grey; 3]),
        _ => None,
    }
}

/// Why a file without layers that can be read is refused.
fn refusal(headers: &[Header]) -> String {
    let names = channel_names(headers);
    let has = |wanted: &str| headers.iter().flat_map(|h| &h.channels.list).any(|c| c.name.eq(wanted));
    if has("RY") || has("BY") {
        return format!(
            "has channels {names}: luminance and chroma, which are not supported; it must have R, G and B"
        );
    }
    format!("has channels {names}; it must have R, G and B, or Y without RY and BY, or a single one")
}

/// Rejects subsampled channels: the decoder assumes one sample per pixel.
fn whole(headers: &[Header], layer: Layer) -> Result<Layer, String> {
    match headers[layer.header].channels.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
        Some(c) => {
            let name = channel_name(c);
            Err(format!("has a subsampled channel {name}; each must have a sample for every pixel"))
        }
        None => Ok(layer),
    }
}

/// How many names are listed in a message.
const MOST: usize = 12;

/// The names of the layers that have one, for messages.
fn listed(layers: &[Layer]) -> String {
    let named = || layers.iter().filter(|layer| !layer.name.is_empty());
    let names: Vec<String> = named().take(MOST).map(|layer| shown(&layer.name)).collect();
    let more = if named().nth(MOST).is_some() { ", and more" } else { "" };
    format!("{}{more}", names.join(", "))
}

/// The names of the first channels, for messages.
fn channel_names(headers: &[Header]) -> String {
    let all = || headers.iter().flat_map(|h| &h.channels.list);
    let names: Vec<String> = all().take(MOST).map(channel_name).collect();
    let more = if all().nth(MOST).is_some() { ", and more" } else { "" };
    format!("{}{more}", names.join(", "))
}

fn channel_name(channel: &ChannelDescription) -> String {
    shown(&channel.name.to_string())
}

/// A name for messages: shortened, and escaped so that the message stays on one line.
fn shown(name: &str) -> String {
    const LONGEST: usize = 20;
    name.chars().take(LONGEST).flat_map(char::escape_debug).collect()
}
