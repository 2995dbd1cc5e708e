//! The elements: symbols, radii and colours.
