//! Culling: which rays may hit a ball within a bounding sphere? A test of 13 operations without root and division, which
//! never refuses what the exact formula accepts.

use lanes::{Lanes, V3};

/// The factor by which [`may_meet`] shrinks the squared distance from the origin to the centre, for rays in these
/// directions.
#[inline(always)]
pub(crate) fn trust<L: Lanes>(direction: V3<L>) -> L::F {
    let length_error = L::abs(direction.dot(direction) - L::f(1.0));
    L::f(1.0 - 1.0 / (1 << 17) as f32) - L::f(4.0) * length_error
}

/// False only where the reference hits no ball that lies within the sphere of this centre and squared radius.
///
/// Why it is conservative. With f from the centre of a ball to the origin, b = f . d, u = 2^-24, and D the distance of the centre from the
/// line of the ray, which balls does the reference accept? Its `f` errs by u |f|, its `b` by 4u |f|, so its `nearest` by
/// 8u |f| from `f - d b`, whose length is at least D whatever the length of d. It accepts if the square of `nearest`
/// is at most r^2, so if D <= r (1 + 4u) + 8u |f|; and moreover only if b <= 4u |f| or (glass) the origin lies
/// within the ball but for rounding. Hence the ray, t >= 0, comes as near as r + 13u |f| (1).
///
/// Let the ball lie within a sphere with centre C and radius R, and F go from C to the origin. If |F| <= R, the test
/// below passes. Else |f| <= 2 |F|, so by (1) the ray comes as near to C as R + 26u |F|, whose square is at most
/// R^2 + 53u |F|^2. The squared distance of C from the ray is |F|^2 - max(-F . d, 0)^2 / |d|^2. Rounding F, its
/// square, and F . d squared errs by less than 20u |F|^2 in sum; leaving out the division by at most
/// 4 | |d|^2 - 1 | |F|^2. The factor `trust` is 1 less 128u and less the latter, which is enough. A single ball is
/// culled by its own sphere.
#[inline(always)]
pub(crate) fn may_meet<L: Lanes>(
    origin: V3<L>,
    direction: V3<L>,
    trust: L::F,
    center: V3<L>,
    r2: L::F,
) -> L::M {
    let (square, ahead) = way_to(origin, direction, center);
    let ahead = L::max(ahead, L::f(0.0));
    L::le(L::fused(square, trust, -r2), ahead * ahead)
}

/// The factor of [`may_meet_before`], from that of [`may_meet`].
#[inline(always)]
pub(crate) fn trust_before<L: Lanes>(trust: L::F) -> L::F {
    trust - L::f(1.0 / (1 << 17) as f32)
}

/// As [`may_meet`], for rays that end at `limit`: false only where the reference hits no ball within the sphere nearer than that.
/// Not for rays that leave one of these balls.
///
/// Of the ray up to s = min(max(F . d, 0), limit), the squared distance of C from the point at s is |F|^2 - s (2 F . d - s) if d
/// is of length 1. With the names above, how near does the ray come to a ball before a hit at a distance t' that the reference
/// accepts? From within the ball, it is near at once. If it has passed the point nearest to the ball by then, as near as there: r + 13u |f|. Else t' is that of the first
/// crossing, b' less the root of the discriminant, up to the errors of both and of the quotient that gives it. Where
/// the exact crossing is not beyond t', the ray has come as near as r; and where it is, by less than 16u |f| + 8u (f^2 + r^2) / (root + |b|),
/// of which only the share root / r leads towards the ball, and the root is at most |b| as the origin is outside. That is at most
/// r + 40u |f|. As before |f| <= 2 |F|, so the square of R + 80u |F| is at most R^2 + 161u |F|^2, and with the
/// roundings of these lines, 20u |F|^2, less than the 256u of this factor.
#[inline(always)]
pub(crate) fn may_meet_before<L: Lanes>(
    origin: V3<L>,
    direction: V3<L>,
    trust: L::F,
    center: V3<L>,
    r2: L::F,
    limit: L::F,
) -> L::M {
    let (square, ahead) = way_to(origin, direction, center);
    let s = L::min(L::max(ahead, L::f(0.0)), limit);
    L::le(L::fused(square, trust, -r2), s * (ahead + (ahead - s)))
}

/// The squared distance from the origins of rays to a centre, and how far ahead along the ray it lies.
#[inline(always)]
fn way_to<L: Lanes>(origin: V3<L>, direction: V3<L>, center: V3<L>) -> (L::F, L::F) {
    let f = center - origin;
    let ahead = L::fused(f.x, direction.x, L::fused(f.y, direction.y, f.z * direction.z));
    (L::fused(f.x, f.x, L::fused(f.y, f.y, f.z * f.z)), ahead)
}
