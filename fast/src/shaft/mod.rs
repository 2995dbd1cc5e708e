//! Shafts: which spheres can the rays of a whole batch meet?
//!
//! Camera rays of neighbouring pixels, and shadow rays from them to a lamp, run close together. All that they can meet
//! meets a shaft around them (Haines and Wallace, "Shaft culling for efficient ray-cast radiosity", 1991), often but a few
//! spheres:
//!
//! ```text
//! two bounding balls: around the origins of the rays, and around their ends
//! the shaft is the convex hull of both: the balls around o + s a of radius p + s q, for s in [0, 1]
//! for each packet of spheres, of centre c and radius r:
//!     s where |c - (o + s a)|^2 - (r + p + s q)^2 is least
//!     append those where it is not above 0 to a list
//! ```
//!
//! If few are listed, the rays are tested against these one by one, as if there were no others; else by the search. All walls are
//! listed, but for those that no ray meets first ([`walls`]).
//!
//! Why nothing is missed. Let u = 2^-24, and `scale` be a length that no coordinate of the rays' ends or of the spheres exceeds,
//! radii included. By [`may_meet`](crate::hierarchy), the reference lets a ray hit a ball only if it comes as near to it as
//! 13u |f|, with f from its centre to the origin, so 26u `scale`. If it takes a hit for nearer than `t`, where it is not, that is
//! by 16u |f| r in the square of half a chord, so that the end of the ray is within another 8u |f| of the ball.
//! Bounding balls, the vector between them and that to c err by 8u `scale` in sum. With |q| <= |a| / 2, `s` is off the least
//! by so little that the difference grows by less than 200u^2 `scale`^2. All that is less than the [`SLACK`](hull) of 256u `scale` by
//! which each radius is larger.

mod culling;
mod hull;
mod walls;

pub(crate) use culling::{Culled, Culling};
