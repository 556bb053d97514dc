//! The surface of revolution and the questions that can be asked of it.
//!
//! ```text
//! Ray -> Frame: LocalRay -> Meridian -> ShellTree -> pieces -> root: (s, t) -> Hit -> Interaction
//! ```

use std::sync::OnceLock;

use crate::arc_length::{ArcLengths, Stretches};
use crate::batch::{AllHits, Gathered, Hits, Rays};
use crate::engine::{Engine, EngineOptions, Method, Polyline, Statistics, TreeNode};
use crate::frame::{Frame, LocalRay, largest_stretch};
use crate::interaction::{Interaction, interaction};
use crate::meridian::Meridian;
use crate::numeric::gamma;
use crate::orientation::outward_senses;
use crate::piece::{self, Jet, Piece};
use crate::pieces::Pieces;
use crate::profile::Point;
use crate::rings::Rings;
use crate::root;
use crate::{Affine, Bounds, Profile, Ray, Vec3};

/// Where a ray meets a surface: the cheap answer, from which [`Surface::interaction`] makes the
/// full one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter, in units of the ray's direction.
    pub t: f64,
    /// The piece of the profile that was hit.
    pub piece: u32,
    /// The parameter on that piece, from 0 to 1.
    pub s: f64,
}

/// A surface of revolution, ready for rays: built once from a [`Profile`], then immutable.
///
/// The axis of revolution is the z axis. Rays whose origin or direction is not finite, or whose
/// direction is zero, hit nothing.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Made when it is asked for.
    profile: OnceLock<Profile>,
    pub(crate) frame: Frame,
    engine: Engine,
    /// Where frusta come from, if the engine works on them.
    polyline: Option<Polyline>,
    /// The pieces in drawing order, lowered by `center_z`, and the profile.
    pub(crate) pieces: Pieces,
    /// What belongs to each piece, or to each curve of the polyline, but is of no use to the search.
    pub(crate) details: Vec<Detail>,
    pub(crate) center_z: f64,
    /// The radius of the sphere round the surface about its centre.
    pub(crate) radius: f64,
    /// The arc length of the profile.
    pub(crate) lengths: ArcLengths,
    r_max: f64,
    z_range: [f64; 2],
    rings: Rings,
}

/// What belongs to a piece beside its curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Detail {
    /// The segment of the profile that the piece was cut from, times two, and 1 if the normal is to the left of the drawing
    /// direction.
    segment: u32,
    /// Its arc length.
    pub(crate) length: Stretches,
}

impl Detail {
    fn new(segment: u32, sense: f64, length: Stretches) -> Self {
        Self { segment: segment << 1 | u32::from(sense < 0.0), length }
    }

    /// The segment of the profile that the piece was cut from.
    pub(crate) fn segment(self) -> u32 {
        self.segment >> 1
    }

    /// 1 if the normal is to the right of the drawing direction, -1 if to the left.
    #[inline]
    pub(crate) fn sense(self) -> f64 {
        // No branch, which what is drawn beside what leads to misses.
        if self.segment & 1 == 0 { 1.0 } else { -1.0 }
    }
}

impl Surface {
    /// Builds the exact engine for a profile.
    pub fn new(profile: &Profile) -> Self {
        Self::with_engine(profile, &EngineOptions::default())
    }

    /// Builds an engine of one's choice for a profile.
    ///
    /// All but the exact one replace the profile's curves by a polyline of about
    /// [`samples`](EngineOptions::samples) points, the same for all: each stretch on which neither r
    /// nor z turns gets its share by arc length and is sampled evenly in its parameter; its ends
    /// belong to the polyline always. Hits lie on the frusta that the polyline sweeps. Their normals
    /// are those of the curves at the same parameters, so that point and normal both come
    /// nearer to the exact ones with the square of the number of points.
    pub fn with_engine(profile: &Profile, options: &EngineOptions) -> Self {
        let exact = options.method.is_exact();
        let mut pieces = Vec::new();
        let mut details = Vec::new();
        let mut segment = 0;
        let mut lengths = ArcLengths::new();
        // Lowered before they are cut: far from the origin the points between the ends of a curve are
        // rounded more coarsely than their distance from the centre.
        let center_z = middle(profile);
        let down = Point::new(0.0, -center_z);
        for (subpath, sense) in profile.subpaths().iter().zip(outward_senses(profile)) {
            for curve in subpath.segments() {
                for piece in piece::cut(&curve.moved(down)) {
                    details.push(Detail::new(segment, sense, lengths.push(&piece)));
                    pieces.push(piece);
                }
                segment += 1;
            }
        }

        let ends = || pieces.iter().flat_map(|p: &Piece| [p.start(), p.end()]);
        let r_max = ends().fold(0.0_f64, |m, p| m.max(p.r));
        let [low, high] = ends().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
            [low.min(p.z), high.max(p.z)]
        });
        let radius = r_max.hypot(high.max(-low)) * (1.0 + gamma(8));
        let z_range = [low + center_z, high + center_z];
        // What lies on the axis sweeps nothing.
        let swept = |p: &Piece| p.r != [0.0; 4];
        if pieces.iter().any(swept) {
            let mut of_details = pieces.iter().map(swept);
            details.retain(|_| of_details.next() == Some(true));
            pieces.retain(swept);
        }
        details.shrink_to_fit();
        lengths.shrink_to_fit();
        let mut polyline = None;
        if !exact {
            let (sources, frusta) = Polyline::sample(pieces, options.samples);
            (polyline, pieces) = (Some(sources), frusta);
        }
        let packed = options.method == Method::Wide;
        Self {
            profile: OnceLock::new(),
            frame: Frame::unplaced(center_z, radius),
            engine: Engine::new(&pieces, radius, options),
            rings: Rings::new(&pieces),
            polyline,
            pieces: if packed {
                Pieces::new(profile, &pieces, details.iter().map(|d| d.segment()), center_z)
            } else {
                Pieces::listed(profile, pieces, center_z)
            },
            details,
            center_z,
            radius,
            lengths,
            r_max,
            z_range,
        }
    }

    /// The profile that the surface was built from.
    ///
    /// The surface has it in a form that takes half the memory. The first call makes it anew, and the surface keeps it.
    pub fn profile(&self) -> &Profile {
        self.profile.get_or_init(|| self.pieces.profile())
    }

    /// Whether the [profile bounds a solid](Profile::bounds_solid).
    pub fn bounds_solid(&self) -> bool {
        self.pieces.open_subpath().is_none()
    }

    /// The number of pieces that the profile was cut into.
    pub fn piece_count(&self) -> usize {
        self.pieces.len()
    }

    /// The points at which the pieces begin and end, in drawing order. Where a piece does not begin
    /// where the one before it ends, a new chain begins.
    pub fn piece_ends(&self) -> impl Iterator<Item = [Point; 2]> + '_ {
        let raised = |p: Point| Point::new(p.r, p.z + self.center_z);
        self.pieces.iter().map(move |piece| [raised(piece.start()), raised(piece.end())])
    }

    /// The number of nodes in the engine's tree.
    pub fn node_count(&self) -> usize {
        self.engine.node_count()
    }

    /// The engine's tree, in depth-first order, made anew at every call. The wide engine has none.
    pub fn tree(&self) -> Vec<TreeNode> {
        self.engine.view(&self.pieces.iter().collect::<Vec<_>>(), self.center_z)
    }

    /// Where a ray is inside the outer and outside the inner wall of a node of [`tree`](Self::tree),
    /// between its two planes: none, one or two intervals of the ray's parameter.
    pub fn intersection_intervals(&self, ray: &Ray, node: usize) -> Vec<[f64; 2]> {
        let Some(local) = self.frame.enter(ray) else { return Vec::new() };
        let meridian = Meridian::new(local.origin, local.direction);
        let intervals = self.engine.intervals(node, &meridian, local.range);
        intervals.into_iter().map(|interval| interval.map(|t| local.world_t(t))).collect()
    }

    /// The work done since the surface was built; `None` unless it is [counted].
    ///
    /// [counted]: EngineOptions::counted
    pub fn statistics(&self) -> Option<Statistics> {
        self.engine.statistics()
    }

    /// The index of the profile's segment that a hit lies on, counted over all subpaths.
    pub fn segment(&self, hit: &Hit) -> usize {
        self.detail_at(hit).segment() as usize
    }

    /// The hit with the smallest t in the ray's range, if there is one.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.closest_from(&self.frame, ray)
    }

    /// Whether there is any hit in the ray's range.
    #[inline]
    pub fn any(&self, ray: &Ray) -> bool {
        self.any_from(&self.frame, ray)
    }

    /// All hits in the ray's range, in order of t. `hits` is cleared first.
    ///
    /// If the profile [bounds a solid](Profile::bounds_solid), a whole line has an even number of
    /// hits. A tangency counts as two hits or as none.
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        self.all_from(&self.frame, ray, hits);
    }

    /// Whether many rays have any hit, as [`any`](Self::any) tells for each; `hits` is as long as there
    /// are rays, what lies beyond either is left out.
    pub fn any_of_many(&self, rays: &Rays<'_>, hits: &mut [bool]) {
        self.any_of_many_from(&self.frame, rays, hits);
    }

    /// The closest hits of many rays: the same as [`closest`](Self::closest) finds for each, t apart
    /// by rounding.
    pub fn closest_of_many(&self, rays: &Rays<'_>, hits: &mut Hits) {
        self.closest_of_many_from(&self.frame, rays, hits);
    }

    /// All hits of many rays: the same as [`all`](Self::all) finds for each, t apart by rounding. What `hits` held is lost.
    ///
    /// ```
    /// use rondure::{AllHits, Profile, RayColumns, Ray, Surface, Vec3};
    ///
    /// let ball = Surface::new(&Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1")?);
    /// let rays = [0.0, 2.0, 0.6].map(|z| Ray::new(Vec3::new(-5.0, 0.0, z), Vec3::X));
    /// let mut hits = AllHits::default();
    /// ball.all_of_many(&RayColumns::from_iter(&rays).rays(), &mut hits);
    /// assert_eq!(hits.starts, [0, 2, 2, 4]);
    /// assert!(hits.of(2).all(|hit| ((hit.t - 5.0).abs() - 0.8).abs() < 1e-14));
    /// # Ok::<(), rondure::ProfileError>(())
    /// ```
    pub fn all_of_many(&self, rays: &Rays<'_>, hits: &mut AllHits) {
        self.all_of_many_from(&self.frame, rays, hits);
    }

    /// The full answer for a hit that this surface reported for this ray.
    pub fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        interaction(
            self,
            &self.frame,
            &Affine::IDENTITY,
            self.rounding(&Affine::IDENTITY),
            ray,
            hit,
        )
    }

    /// The box round the surface.
    pub fn bounds(&self) -> Bounds {
        let (r, [low, high]) = (self.r_max, self.z_range);
        Bounds { min: Vec3::new(-r, -r, low), max: Vec3::new(r, r, high) }
    }

    /// The box round the surface placed in the world, padded by its [rounding](Self::rounding).
    ///
    /// The box is that of the surface's [rings](crate::rings).
    pub(crate) fn placed_bounds(&self, placement: &Affine, rounding: f64) -> Bounds {
        let bounds = self.rings.placed_bounds(self.center_z, placement);
        let pad = Vec3::splat(rounding);
        Bounds { min: bounds.min - pad, max: bounds.max + pad }
    }

    /// How far off the placed surface rounding can move a computed point of it; see
    /// [`placed_rounding`].
    pub(crate) fn rounding(&self, placement: &Affine) -> f64 {
        self.rounding_with(placement, placement.inverse_rows().as_ref())
    }

    /// The same, given the rows of the placement's inverse.
    pub(crate) fn rounding_with(&self, placement: &Affine, inverse: Option<&[Vec3; 3]>) -> f64 {
        placed_rounding(placement, inverse, Vec3::new(0.0, 0.0, self.center_z), self.radius)
    }

    /// The arc length of the profile.
    #[inline]
    pub(crate) fn length(&self) -> f64 {
        self.lengths.whole()
    }

    #[inline]
    pub(crate) fn closest_from(&self, frame: &Frame, ray: &Ray) -> Option<Hit> {
        if let Some(wide) = self.engine.wide() {
            return wide.closest(&self.pieces, frame, ray);
        }
        self.closest_by_walk(frame, ray)
    }

    /// The same with any engine.
    #[inline(never)]
    fn closest_by_walk(&self, frame: &Frame, ray: &Ray) -> Option<Hit> {
        let local = frame.enter(ray)?;
        let meridian = Meridian::new(local.origin, local.direction);
        let mut closest: Option<Hit> = None;
        let mut end = local.range[1];
        self.engine.walk(&local, &meridian, |piece| {
            self.hits_on(piece, ray, &local, &meridian, |hit, t| {
                let order = |h: &Hit| (h.t, h.piece);
                if closest.is_none_or(|best| order(&hit) < order(&best)) {
                    closest = Some(hit);
                    end = t;
                }
            });
            end
        });
        closest
    }

    #[inline]
    pub(crate) fn any_from(&self, frame: &Frame, ray: &Ray) -> bool {
        if let Some(wide) = self.engine.wide() {
            return wide.any(&self.pieces, frame, ray);
        }
        self.any_by_walk(frame, ray)
    }

    /// The same with any engine.
    #[inline(never)]
    fn any_by_walk(&self, frame: &Frame, ray: &Ray) -> bool {
        let Some(local) = frame.enter(ray) else { return false };
        let meridian = Meridian::new(local.origin, local.direction);
        let mut end = local.range[1];
        self.engine.walk(&local, &meridian, |piece| {
            self.hits_on(piece, ray, &local, &meridian, |_, _| end = f64::NEG_INFINITY);
            end
        });
        end == f64::NEG_INFINITY
    }

    pub(crate) fn all_from(&self, frame: &Frame, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        if let Some(wide) = self.engine.wide() {
            return wide.all(&self.pieces, frame, ray, hits);
        }
        let Some(local) = frame.enter(ray) else { return };
        let meridian = Meridian::new(local.origin, local.direction);
        self.engine.walk(&local, &meridian, |piece| {
            self.hits_on(piece, ray, &local, &meridian, |hit, _| hits.push(hit));
            local.range[1]
        });
        hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.piece.cmp(&b.piece)));
    }

    pub(crate) fn any_of_many_from(&self, frame: &Frame, rays: &Rays<'_>, hits: &mut [bool]) {
        if let Some(wide) = self.engine.wide() {
            return wide.any_of_many(&self.pieces, frame, rays, hits);
        }
        for (i, hit) in hits.iter_mut().enumerate().take(rays.len()) {
            *hit = self.any_from(frame, &rays.get(i));
        }
    }

    pub(crate) fn closest_of_many_from(&self, frame: &Frame, rays: &Rays<'_>, hits: &mut Hits) {
        if let Some(wide) = self.engine.wide() {
            return wide.closest_of_many(&self.pieces, frame, rays, hits);
        }
        hits.clear(rays.len());
        for i in 0..rays.len() {
            hits.set(i, self.closest_from(frame, &rays.get(i)));
        }
    }

    pub(crate) fn all_of_many_from(&self, frame: &Frame, rays: &Rays<'_>, hits: &mut AllHits) {
        let mut gathered = Gathered::new(rays.len());
        match self.engine.wide() {
            Some(wide) => wide.all_of_many(&self.pieces, frame, rays, &mut gathered),
            None => {
                let mut own = Vec::new();
                for i in 0..rays.len() {
                    self.all_from(frame, &rays.get(i), &mut own);
                    gathered.add(i, &own);
                }
            }
        }
        gathered.sorted(hits);
    }

    /// All hits of the whole line, in no particular order, each with its step (see
    /// [`root::crossings`]).
    pub(crate) fn crossings_from(
        &self,
        frame: &Frame,
        ray: &Ray,
        mut report: impl FnMut(Hit, i32),
    ) {
        let Some(local) = frame.enter(&ray.whole()) else { return };
        let meridian = Meridian::new(local.origin, local.direction);
        self.engine.walk(&local, &meridian, |piece| {
            root::crossings(
                self.pieces.at(piece as usize, &mut None),
                &meridian,
                |s, local_t, step| {
                    report(Hit { t: local.world_t(local_t), piece, s }, step);
                },
            );
            local.range[1]
        });
    }

    /// All hits, from all pieces, without any shell: what every engine must agree with.
    #[cfg(test)]
    pub(crate) fn all_by_brute_force(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        let Some(local) = self.frame.enter(ray) else { return };
        let meridian = Meridian::new(local.origin, local.direction);
        for piece in 0..self.pieces.len() as u32 {
            self.hits_on(piece, ray, &local, &meridian, |hit, _| hits.push(hit));
        }
        hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.piece.cmp(&b.piece)));
    }

    /// Reports the hits on one piece within the ray's range, with their local parameters.
    #[inline]
    fn hits_on(
        &self,
        piece: u32,
        ray: &Ray,
        local: &LocalRay,
        meridian: &Meridian,
        mut report: impl FnMut(Hit, f64),
    ) {
        root::hits(self.pieces.at(piece as usize, &mut None), meridian, |s, local_t| {
            let t = local.world_t(local_t);
            if ray.t_min <= t && t <= ray.t_max {
                report(Hit { t, piece, s }, local_t);
            }
        });
    }
}

/// The middle of the heights of a profile.
fn middle(profile: &Profile) -> f64 {
    let ends = profile.segments().flat_map(piece::cut).flat_map(|p| [p.start().z, p.end().z]);
    let [low, high] =
        ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
    0.5 * low + 0.5 * high
}

/// How far off a placed surface rounding can move a computed point of it, and how far off a ray's true
/// course it can move the ray in the surface's frame, taken back to the world. The surface lies within
/// `radius` of `center` in its own frame; `inverse` has the rows of the placement's inverse.
///
/// Each takes fewer than 16 operations on numbers that are no larger than the sums below.
pub(crate) fn placed_rounding(
    placement: &Affine,
    inverse: Option<&[Vec3; 3]>,
    center: Vec3,
    radius: f64,
) -> f64 {
    let [x, y, z] = placement.columns;
    let size = largest_stretch(placement) * radius;
    // The rounding of the map into the surface's frame, brought back, grows with the condition of the
    // map.
    let condition = inverse.map_or(1.0, |rows| {
        let widest = rows.iter().map(|r| r.abs().dot(Vec3::splat(1.0))).fold(0.0, f64::max);
        widest * [x, y, z].iter().map(|c| c.max_abs()).fold(0.0, f64::max)
    });
    let world = placement.translation.max_abs()
        + placement.vector(center).max_abs()
        + placement.point(center).max_abs();
    gamma(16) * (size * (1.0 + condition) + world)
}

impl Surface {
    /// What belongs to the curve of the profile that a hit lies on.
    #[inline]
    pub(crate) fn detail_at(&self, hit: &Hit) -> &Detail {
        let piece = hit.piece as usize;
        match &self.polyline {
            Some(polyline) => &self.details[polyline.place(piece, hit.s).0],
            None => &self.details[piece],
        }
    }

    /// The arc length of the profile from its beginning to a hit.
    pub(crate) fn length_at(&self, hit: &Hit) -> f64 {
        let piece = hit.piece as usize;
        match &self.polyline {
            Some(polyline) => {
                let (curve, s) = polyline.place(piece, hit.s);
                self.lengths.until(self.details[curve].length, &polyline.curves[curve], s)
            }
            None => {
                let mut room = None;
                let curve = self.pieces.at(piece, &mut room);
                self.lengths.until(self.details[piece].length, curve, hit.s)
            }
        }
    }

    /// The point and the derivative by s of the profile at a hit, in the surface's own frame.
    #[inline]
    pub(crate) fn profile_at(&self, hit: &Hit) -> (Point, Point) {
        let index = hit.piece as usize;
        let jet = self.pieces.packed_jet(index, hit.s);
        let Jet { point, tangent } = jet.unwrap_or_else(|| self.walked_jet(hit));
        if tangent == Point::default() {
            // A handle of length zero: the curve sets out towards the rest of itself.
            let [start, end] = self.pieces.ends(index);
            return (point, end - start);
        }
        (point, tangent)
    }

    /// The same with the engines that walk along pieces; if they do so along frusta, the derivative is that of the curve.
    fn walked_jet(&self, hit: &Hit) -> Jet {
        let index = hit.piece as usize;
        let jet = self.pieces.jet(index, hit.s);
        let Some(polyline) = &self.polyline else { return jet };
        let (curve, s) = polyline.place(index, hit.s);
        Jet { tangent: polyline.curves[curve].jet(s).tangent, ..jet }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The hits of a ray on every piece, without any shell.
    fn brute_force(surface: &Surface, ray: &Ray) -> Vec<Hit> {
        let mut hits = Vec::new();
        surface.all_by_brute_force(ray, &mut hits);
        hits
    }

    /// Numbers in [-1, 1), the same at every run.
    fn random_numbers() -> impl FnMut() -> f64 {
        let mut state = 7_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    #[test]
    fn shells_lose_no_hit() {
        let mut random = random_numbers();
        for path in [
            include_str!("../../../profiles/sphere.path"),
            include_str!("../../../profiles/cone.path"),
            include_str!("../../../profiles/cylinder.path"),
            include_str!("../../../profiles/torus.path"),
            include_str!("../../../profiles/vase.path"),
            include_str!("../../../profiles/goblet.path"),
            include_str!("../../../profiles/pawn.path"),
            include_str!("../../../profiles/column.path"),
            // Several subpaths, folds in z, self-crossings, nearly horizontal parts.
            "M 1 0 C 3 2 -0.5 2 2 0 Z M 4 1 L 5 1.0000000001 L 5 3 Q 3 2 4 1 M 0 4 A 3 1 20 1 1 0 6",
        ] {
            let surface = Surface::new(&Profile::from_path_data(path).unwrap());
            let (center, extent) = (surface.bounds().center(), surface.bounds().extent());
            let mut hits = Vec::new();
            for i in 0..20_000 {
                let mut point =
                    || Vec3::new(random() * extent.x, random() * extent.y, random() * extent.z);
                let (origin, mut direction) = (center + point(), point());
                match i % 4 {
                    1 => direction.z *= 1e-12,
                    2 => direction = Vec3::new(1e-9 * direction.x, direction.y * 1e-7, direction.z),
                    _ => {}
                }
                let ray =
                    Ray::line(origin, direction).with_range([f64::NEG_INFINITY, -0.2][i % 2], 0.7);
                let expected = brute_force(&surface, &ray);
                surface.all(&ray, &mut hits);
                let near = 1e-12 * surface.radius / direction.length();
                let same = |a: &Hit, b: &Hit| a.piece == b.piece && (a.t - b.t).abs() <= near;
                assert_eq!(hits.len(), expected.len(), "{path} {ray:?}");
                assert!(hits.iter().zip(&expected).all(|(a, b)| same(a, b)), "{path} {ray:?}");
                let closest = surface.closest(&ray);
                assert_eq!(closest.is_some(), !expected.is_empty(), "{path} {ray:?}");
                assert!(closest.iter().zip(&expected).all(|(a, b)| same(a, b)), "{path} {ray:?}");
                assert_eq!(surface.any(&ray), !expected.is_empty(), "{path} {ray:?}");
            }
        }
    }
}
