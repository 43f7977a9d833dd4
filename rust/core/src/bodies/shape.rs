//! Where nodes, edges and triangles touch a body, and how deep.
//!
//! A cylinder is all points within the radius r of its axis. An endless axis is a line; one of half-length H ends in
//! round caps of radius r, so that depth and normal are continuous. (Nodes alone may have flat ends: d = min(r - |v|,
//! H - |z|).) With v the vector from the nearest point of the axis to the nearest point p of the element,
//!
//!     depth d = r - |v|,   normal n = v/|v|,   p = sum of w_i x_i
//!
//! For an edge a -> b beside a line, in the plane across the axis: t = clamp(-a.e/e^2, 0, 1), w = (1 - t, t).
//!
//! On an edge parallel to the axis every point is nearest. So between an angle of 0.1 rad and 0 the contact passes
//! smoothly to its two ends, with the share m of the nearest point and (1 - m)/2 of each end, where e' is the part of e
//! across the axis:
//!
//!     m = q^2 (3 - 2 q),   q = min(1, e'^2/(0.01 e^2))
//!
//! A triangle that an axis does not pierce is nearest to it on an edge, or inside, beside an end of the axis. The
//! nearest point of all would jump between edges that are equally deep, where the triangle is parallel to the axis. So
//! edges are elements of their own, and the contacts of a triangle are those of its nearest points to both ends. A
//! triangle that an axis pierces has the depth r and no direction.
//!
//! A plane is the half-space below its normal, d = -n.(x - c) at each node, which is exact for edges and triangles too.

use nalgebra::Vector3;

use crate::arrays::jacobian::Block;
use crate::bodies::real::{Real, Vector, constant, cross, difference, product, scaled, sum};
use crate::bodies::rigid_body::Pose;

/// sin^2 of the angle to the axis below which an edge counts as nearly parallel.
const NEARLY_PARALLEL: f64 = 0.01;

/// The nodes of the sides of a triangle.
const SIDES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// The ends of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ends {
    /// It is endless.
    None,
    /// Caps of the cylinder's radius beyond this half-length \[m\].
    Round(f64),
    /// Flat ends at this half-length \[m\], for nodes alone.
    Flat(f64),
}

/// The shape of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// About the direction of the pose.
    Cylinder {
        /// r \[m\].
        radius: f64,
        /// Its ends.
        ends: Ends,
    },
    /// The half-space below the normal, the direction of the pose.
    Plane,
}

/// A contact of an element of K nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch<T, const K: usize> {
    /// Share of the contact.
    pub share: T,
    /// w.
    pub weights: [T; K],
    /// d \[m\].
    pub depth: T,
    /// n, out of the body.
    pub normal: Vector<T>,
}

/// The contacts of an element: that of its nearest point, and those of its ends where it is a nearly parallel edge; or
/// those of a triangle with the ends of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touches<T, const K: usize> {
    /// The contacts; the first is there if any is.
    pub all: [Option<Touch<T, K>>; 3],
    /// dm/de for nearly parallel edges \[1/m\].
    pub share_slope: Option<Vector<T>>,
}

impl<T, const K: usize> Touches<T, K> {
    fn of(touch: Option<Touch<T, K>>) -> Self {
        Self { all: [touch, None, None], share_slope: None }
    }
}

fn clamped<T: Real>(value: T, low: f64, high: f64) -> T {
    if value.value() < low {
        T::of(low)
    } else if value.value() > high {
        T::of(high)
    } else {
        value
    }
}

/// The share t of the point nearest to the origin on v + t e.
fn nearest_share<T: Real>(v: Vector<T>, e: Vector<T>) -> T {
    let square = product(e, e);
    if square.value() > 0.0 { clamped(-product(v, e) / square, 0.0, 1.0) } else { T::of(0.5) }
}

impl Shape {
    /// A size: depth has a bound of a share of it. A half-space has none \[m\].
    pub fn size(&self) -> Option<f64> {
        match *self {
            Self::Cylinder { radius, ends: Ends::Flat(half) } => Some(half.min(radius)),
            Self::Cylinder { radius, .. } => Some(radius),
            Self::Plane => None,
        }
    }

    /// Whether triangles feel its ends.
    pub fn has_round_ends(&self) -> bool {
        matches!(self, Self::Cylinder { ends: Ends::Round(_), .. })
    }

    /// k n (n . p) for a node in contact with the nearest copy, radially or, where ends are flat, along the axis too.
    pub fn stiffest_product(&self, poses: &[Pose], x: [f64; 3], p: [f64; 3], stiffness: f64) -> [f64; 3] {
        let depth = |pose: &&Pose| self.depth(pose, &[x]);
        let Some(pose) = poses.iter().max_by(|a, b| depth(a).total_cmp(&depth(b))) else { return [0.0; 3] };
        let along = |direction: [f64; 3]| scaled(stiffness * product(direction, p), direction);
        let Self::Cylinder { ends, .. } = *self else { return along(pose.direction) };
        let (v, _) = self.off_axis(pose, x);
        let length = norm(v).max(f64::MIN_POSITIVE);
        let radial = along(v.map(|component| component / length));
        if matches!(ends, Ends::Flat(_)) { sum(radial, along(pose.direction)) } else { radial }
    }

    /// The derivative of the force of a node in contact by its position \[N/m\]: -k along the normal n; k d/r across it
    /// on a side, since the normal rotates with the azimuth, and on a round cap.
    pub fn derivative_at(&self, pose: &Pose, x: [f64; 3], stiffness: f64) -> Option<Block> {
        let touch: Touch<f64, 1> = self.touch_of_point(pose, &[x], 0)?;
        let (n, u) = (Vector3::from(touch.normal), Vector3::from(pose.direction));
        let block = n * n.transpose() * -stiffness;
        let Self::Cylinder { ends, .. } = *self else { return Some(block) };
        let (v, height) = self.off_axis(pose, x);
        let across = match ends {
            Ends::Round(half) if height.abs() > half => Block::identity(),
            Ends::Flat(_) if n.dot(&u) != 0.0 => return Some(block),
            _ => Block::identity() - u * u.transpose(),
        };
        Some(block + (across - n * n.transpose()) * (stiffness * touch.depth / norm(v).max(f64::MIN_POSITIVE)))
    }

    /// A bound of n (n . p) for any place of contact: p across the axis, or all of it where the shape has ends.
    pub fn bound_of_product(&self, poses: &[Pose], p: [f64; 3]) -> [f64; 3] {
        match (self, poses) {
            (Self::Cylinder { ends: Ends::None, .. }, [pose, others @ ..])
                if others.iter().all(|other| other.direction == pose.direction) =>
            {
                difference(p, scaled(product(p, pose.direction), pose.direction))
            }
            _ => p,
        }
    }

    /// The contacts of an element of one, two or three nodes.
    #[inline(always)]
    pub fn touches<T: Real, const K: usize>(&self, pose: &Pose, x: &[Vector<T>; K]) -> Touches<T, K> {
        match K {
            1 => Touches::of(self.touch_of_point(pose, x, 0)),
            2 => self.touches_of_edge(pose, x),
            _ => self.touches_of_triangle(pose, x),
        }
    }

    /// The largest depth of an element \[m\]; negative outside: its distance.
    pub fn depth<const K: usize>(&self, pose: &Pose, x: &[[f64; 3]; K]) -> f64 {
        match *self {
            Self::Plane => {
                x.iter().map(|p| -product(pose.direction, difference(*p, pose.centre))).fold(f64::MIN, f64::max)
            }
            Self::Cylinder { radius, ends: Ends::Flat(half) } => {
                let (v, height) = self.off_axis(pose, x[0]);
                (radius - norm(v)).min(half - height.abs())
            }
            Self::Cylinder { radius, .. } => {
                let distance = match K {
                    1 => norm(self.off_axis(pose, x[0]).0),
                    2 => norm(self.off_axis_at_edge(pose, [x[0], x[1]]).0),
                    _ => self.distance_of_triangle(pose, [x[0], x[1], x[2]]),
                };
                radius - distance
            }
        }
    }

    /// The vector from the axis to a point, and its height along the axis.
    #[inline(always)]
    fn off_axis<T: Real>(&self, pose: &Pose, p: Vector<T>) -> (Vector<T>, T) {
        let (from_centre, direction) = (difference(p, constant(pose.centre)), constant(pose.direction));
        let height = product(direction, from_centre);
        let along = match self {
            Self::Cylinder { ends: Ends::Round(half), .. } => clamped(height, -half, *half),
            _ => height,
        };
        (difference(from_centre, scaled(along, direction)), height)
    }

    /// A contact with the side or a round cap by the vector v from the axis.
    #[inline(always)]
    fn touch<T: Real, const K: usize>(radius: f64, v: Vector<T>, weights: [T; K]) -> Option<Touch<T, K>> {
        let square = product(v, v);
        if square.value() >= radius * radius {
            return None;
        }
        let distance = square.sqrt();
        let depth = T::of(radius) - distance;
        if depth.value() <= 0.0 {
            return None;
        }
        let length = if distance.value() < f64::MIN_POSITIVE { T::of(f64::MIN_POSITIVE) } else { distance };
        Some(Touch { share: T::of(1.0), weights, depth, normal: v.map(|component| component / length) })
    }

    /// The contact of one node.
    #[inline(always)]
    fn touch_of_point<T: Real, const K: usize>(
        &self,
        pose: &Pose,
        x: &[Vector<T>; K],
        node: usize,
    ) -> Option<Touch<T, K>> {
        let weights = std::array::from_fn(|k| T::of(f64::from(u8::from(k == node))));
        match *self {
            Self::Plane => {
                let normal = constant(pose.direction);
                let depth = -product(normal, difference(x[node], constant(pose.centre)));
                (depth.value() > 0.0).then_some(Touch { share: T::of(1.0), weights, depth, normal })
            }
            Self::Cylinder { radius, ends } => {
                let (v, height) = self.off_axis(pose, x[node]);
                let touch = Self::touch(radius, v, weights)?;
                let Ends::Flat(half) = ends else { return Some(touch) };
                let sign = 1.0_f64.copysign(height.value());
                let below_end = T::of(half) - T::of(sign) * height;
                if below_end.value() <= 0.0 {
                    None
                } else if below_end.value() < touch.depth.value() {
                    let normal = pose.direction.map(|component| T::of(sign * component));
                    Some(Touch { depth: below_end, normal, ..touch })
                } else {
                    Some(touch)
                }
            }
        }
    }

    /// The vector from the axis to the nearest point of an edge, and its share t.
    #[inline(always)]
    fn off_axis_at_edge<T: Real>(&self, pose: &Pose, [a, b]: [Vector<T>; 2]) -> (Vector<T>, T) {
        let direction = constant(pose.direction);
        let (from_centre, e) = (difference(a, constant(pose.centre)), difference(b, a));
        let (height, rise) = (product(direction, from_centre), product(direction, e));
        let across = difference(from_centre, scaled(height, direction));
        let e_across = difference(e, scaled(rise, direction));
        let share = nearest_share(across, e_across);
        if let Self::Cylinder { ends: Ends::Round(half), .. } = *self {
            let at = (height + share * rise).value();
            if at.abs() > half {
                let from_end = difference(from_centre, scaled(T::of(half.copysign(at)), direction));
                let share = nearest_share(from_end, e);
                return (sum(from_end, scaled(share, e)), share);
            }
        }
        (sum(across, scaled(share, e_across)), share)
    }

    /// The contacts of the edge from the first to the second node.
    #[inline(always)]
    fn touches_of_edge<T: Real, const K: usize>(&self, pose: &Pose, x: &[Vector<T>; K]) -> Touches<T, K> {
        let Self::Cylinder { radius, .. } = *self else { return Touches::of(None) };
        let (v, share) = self.off_axis_at_edge(pose, [x[0], x[1]]);
        let weights = std::array::from_fn(|k| if k == 0 { T::of(1.0) - share } else { share });
        let Some(nearest) = Self::touch(radius, v, weights) else { return Touches::of(None) };
        let (e, direction) = (difference(x[1], x[0]), constant(pose.direction));
        let (square, rise) = (product(e, e), product(e, direction));
        let across = square - rise * rise;
        if across.value() >= NEARLY_PARALLEL * square.value() {
            return Touches::of(Some(nearest));
        }
        let e_across = difference(e, scaled(rise, direction));
        let across = product(e_across, e_across);
        let (q, one) = (across / (square * T::of(NEARLY_PARALLEL)), T::of(1.0));
        let m = q * q * (T::of(3.0) - T::of(2.0) * q);
        let slope = T::of(12.0) * q * (one - q) / (T::of(NEARLY_PARALLEL) * square);
        let other = T::of(0.5) * (one - m);
        let end = |node| self.touch_of_point(pose, x, node).map(|touch| Touch { share: other, ..touch });
        Touches {
            all: [Some(Touch { share: m, ..nearest }), end(0), end(1)],
            share_slope: Some(scaled(slope, difference(e_across, scaled(across / square, e)))),
        }
    }

    /// The distance of a triangle from the axis.
    fn distance_of_triangle(&self, pose: &Pose, x: [[f64; 3]; 3]) -> f64 {
        let half = if let Self::Cylinder { ends: Ends::Round(half), .. } = *self { half } else { f64::INFINITY };
        if is_pierced(x, pose, half) {
            return 0.0;
        }
        let of_edges = SIDES.map(|[i, j]| norm(self.off_axis_at_edge(pose, [x[i], x[j]]).0));
        let of_ends = self.ends_of_axis(pose).into_iter().flatten().map(|end| norm(off_point(x, end).0));
        of_edges.into_iter().chain(of_ends).fold(f64::INFINITY, f64::min)
    }

    /// The ends of an axis that has ends.
    #[inline(always)]
    fn ends_of_axis(&self, pose: &Pose) -> Option<[[f64; 3]; 2]> {
        let Self::Cylinder { ends: Ends::Round(half), .. } = *self else { return None };
        Some([-half, half].map(|height| sum(pose.centre, scaled(height, pose.direction))))
    }

    /// The contacts of a triangle with both ends of the axis.
    #[inline(always)]
    fn touches_of_triangle<T: Real, const K: usize>(&self, pose: &Pose, x: &[Vector<T>; K]) -> Touches<T, K> {
        let (Self::Cylinder { radius, .. }, Some(ends)) = (*self, self.ends_of_axis(pose)) else {
            return Touches::of(None);
        };
        let touches = ends.map(|end| {
            let (v, weights) = off_point([x[0], x[1], x[2]], end);
            Self::touch(radius, v, std::array::from_fn(|k| weights[k]))
        });
        let mut found = touches.into_iter().flatten();
        Touches { all: [found.next(), found.next(), None], share_slope: None }
    }
}

/// The vector from a point to the nearest point of a triangle, and the shares of its nodes there.
fn off_point<T: Real>(x: [Vector<T>; 3], point: [f64; 3]) -> (Vector<T>, [T; 3]) {
    if let Some(found) = inside(x, point) {
        return found;
    }
    let off_side = |[i, j]: [usize; 2]| {
        let (from_point, e) = (difference(x[i], constant(point)), difference(x[j], x[i]));
        let share = nearest_share(from_point, e);
        let mut weights = [T::of(0.0); 3];
        (weights[i], weights[j]) = (T::of(1.0) - share, share);
        (sum(from_point, scaled(share, e)), weights)
    };
    let square = |found: &(Vector<T>, [T; 3])| product(found.0, found.0).value();
    let [first, others @ ..] = SIDES.map(off_side);
    others.into_iter().fold(first, |best, other| if square(&other) < square(&best) { other } else { best })
}

/// Whether a part of an axis, of this length on either side of its centre, goes through a triangle.
fn is_pierced(x: [[f64; 3]; 3], pose: &Pose, half: f64) -> bool {
    // Cramer's rule for x_0 + b e + c f = centre + height direction.
    let (e, f, to) = (difference(x[1], x[0]), difference(x[2], x[0]), difference(pose.centre, x[0]));
    let (across, normal) = (cross(pose.direction, f), cross(to, e));
    let determinant = product(e, across);
    let (second, third) = (product(to, across) / determinant, product(pose.direction, normal) / determinant);
    let height = product(f, normal) / determinant;
    // A parallel triangle has no such numbers.
    second >= 0.0 && third >= 0.0 && second + third <= 1.0 && height.abs() <= half
}

/// The vector from a point to the nearest point of a triangle, if that is inside, and the shares of the nodes there.
fn inside<T: Real>(x: [Vector<T>; 3], point: [f64; 3]) -> Option<(Vector<T>, [T; 3])> {
    let (e, f, to) = (difference(x[1], x[0]), difference(x[2], x[0]), difference(constant(point), x[0]));
    let (ee, ef, ff, et, ft) = (product(e, e), product(e, f), product(f, f), product(e, to), product(f, to));
    let determinant = ee * ff - ef * ef;
    if determinant.value() <= 0.0 {
        return None;
    }
    let (second, third) = ((ff * et - ef * ft) / determinant, (ee * ft - ef * et) / determinant);
    let first = T::of(1.0) - second - third;
    let is_inside = [first, second, third].iter().all(|share| share.value() > 0.0);
    is_inside.then(|| (difference(sum(scaled(second, e), scaled(third, f)), to), [first, second, third]))
}

fn norm(v: [f64; 3]) -> f64 {
    product(v, v).sqrt()
}
