//! Renders that last: stopped, saved, damaged, killed and taken up again, they give the image of a render that was
//! left alone.

mod engines;
