//! All hits of a line with a surface of revolution, with certainty.
//!
//! With a = dx^2 + dy^2, b = ox dx + oy dy, c = ox^2 + oy^2 and the profile r = R/q, z = Z/q the roots of
//!
//! ```text
//! F(s) = a (Z - oz q)^2 + 2 b dz (Z - oz q) q + dz^2 (c q^2 - R^2)
//! ```
//!
//! are the hits, at t = (z - oz)/dz. All of it is integers. A line perpendicular to the axis (dz = 0)
//! has its own branch: z(s) = oz, and then t = (-b -/+ sqrt(a r^2 - k^2))/a.
//!
//! The roots are those of F + epsilon (zero counts as positive, see [`crate::polynomial`]), on
//! all pieces alike. A line through a joint therefore hits exactly one of the two neighbours, or
//! both, or none if it only touches there, and every line crosses a closed profile an even number of
//! times. A line within a plane z = constant does not hit flat parts in that plane.

mod along;

use dashu_int::IBig;
use rondure::{Affine, Profile, Ray, Vec3};

use crate::{
    exact::{Double, align, bits, ratio, ratio_f64, shl, sqrt, to_f64},
    pieces::{Piece, Pieces},
    polynomial::{Bracket, derivative, evaluate, isolate},
};

/// s is found to 2^-`PARAMETER_BITS` on steep rays, and to more on flat ones, so that t is always good to
/// some 1e-28 of the object's size.
const PARAMETER_BITS: i64 = 96;

/// Within this slope of the cone that touches a pole, a line cannot be told to be steeper than it by a
/// tangency estimate of first order.
const CONE_MARGIN: f64 = 1e-6;

/// Lines with |dz| < 2^-`LEVEL_BITS` |d| count as all but level.
const LEVEL_BITS: i64 = 20;

/// A hit of a line.
#[derive(Clone, Copy, Debug)]
pub struct OracleHit {
    /// The parameter on the line, in units of its direction.
    pub t: Double,
    /// The segment of the profile, counted from 0 over all subpaths.
    pub segment: usize,
    /// The parameter on that segment, 0 to 1.
    pub s: f64,
    /// The sine of the angle between the line and the surface: 1 head on, 0 at a tangency. It is 0
    /// too where the profile has no tangent.
    pub incidence: f64,
    /// The smallest incidence on this piece and on the one beyond the nearer joint: how well the
    /// hit is determined if it may as well lie there.
    pub joint_incidence: f64,
    /// The distance in the half plane to the nearer end of the piece, as a fraction of the object's
    /// size.
    pub joint_distance: f64,
    /// How many hits this may be: 1, or more if they lie too close together for isolation, which
    /// happens only within 1e-45 of a tangency.
    pub changes: usize,
}

/// The oracle for one profile.
#[derive(Clone, Debug)]
pub struct Oracle {
    pieces: Pieces,
}

/// A line as integers: lengths in units of 2^length, directions in units of 2^direction. A length
/// of the profile is multiplied by `scale`.
#[derive(Clone, Debug)]
pub struct ExactLine {
    origin: [IBig; 3],
    length: i64,
    direction: [IBig; 3],
    direction_exponent: i64,
    scale: IBig,
    scale_exponent: i64,
}

impl ExactLine {
    /// The line of a ray in the object's own frame.
    pub fn new(ray: &Ray) -> Self {
        let (origin, length) = align(&[ray.origin.x, ray.origin.y, ray.origin.z]);
        let d = ray.direction;
        let (direction, direction_exponent) = align(&[d.x, d.y, d.z]);
        let triple = |v: Vec<IBig>| core::array::from_fn(|i| v[i].clone());
        Self {
            origin: triple(origin),
            length,
            direction: triple(direction),
            direction_exponent,
            scale: IBig::from(1),
            scale_exponent: 0,
        }
    }

    /// The line of a ray in the world, in the frame of an object placed by `map`, without rounding:
    /// the adjugate of the map takes the place of its inverse, and the profile is multiplied by the
    /// determinant.
    pub fn placed(ray: &Ray, map: &Affine) -> Self {
        let flat: Vec<f64> = map.columns.iter().flat_map(|c| [c.x, c.y, c.z]).collect();
        let (m, e) = align(&flat);
        let column = |i: usize| -> [&IBig; 3] { [&m[3 * i], &m[3 * i + 1], &m[3 * i + 2]] };
        let cross = |a: [&IBig; 3], b: [&IBig; 3]| -> [IBig; 3] {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let rows =
            [cross(column(1), column(2)), cross(column(2), column(0)), cross(column(0), column(1))];
        let dot = |a: &[IBig; 3], b: [&IBig; 3]| &a[0] * b[0] + &a[1] * b[1] + &a[2] * b[2];
        let determinant = dot(&rows[0], column(0));
        let sign = if determinant < IBig::ZERO { IBig::from(-1) } else { IBig::from(1) };
        let apply = |v: [&IBig; 3]| core::array::from_fn(|i| dot(&rows[i], v) * &sign);
        let (o, tr, d) = (ray.origin, map.translation, ray.direction);
        let (lengths, length) = align(&[o.x, o.y, o.z, tr.x, tr.y, tr.z]);
        let from = [0, 1, 2].map(|i| &lengths[i] - &lengths[i + 3]);
        let (direction, direction_exponent) = align(&[d.x, d.y, d.z]);
        Self {
            origin: apply([&from[0], &from[1], &from[2]]),
            length: length + 2 * e,
            direction: apply([&direction[0], &direction[1], &direction[2]]),
            direction_exponent: direction_exponent + 2 * e,
            scale: determinant * sign,
            scale_exponent: 3 * e,
        }
    }
}

/// The numbers of a line that all pieces share, with the profile's lengths brought to its unit.
struct Setup {
    a: IBig,
    b: IBig,
    c: IBig,
    k: IBig,
    oz: IBig,
    dz: IBig,
    /// What a length of the profile must be multiplied by.
    lift: IBig,
    /// F = f0 Z^2 + f1 Z q + f2 q^2 + f3 R^2.
    f: [IBig; 4],
    /// t in units of 2^t_exponent is (Z - oz q)/(dz q).
    t_exponent: i64,
    /// log2 of |d| / |dz|, rounded up: how much more precisely s must be known than t.
    flatness: i64,
    /// A length of the object is an integer times 2^unit over `scale`.
    scale: IBig,
    unit: i64,
    /// The power of two that brings the direction's length near 1.
    unit_direction: i64,
    /// The direction's length after that.
    speed: f64,
}

impl Setup {
    fn new(line: &ExactLine, profile_exponent: i64) -> Self {
        let profile_unit = profile_exponent + line.scale_exponent;
        let unit = line.length.min(profile_unit);
        let lift = shl(&line.scale, profile_unit - unit);
        let [ox, oy, oz] = line.origin.each_ref().map(|x| shl(x, line.length - unit));
        let [dx, dy, dz] = line.direction.clone();
        let a = &dx * &dx + &dy * &dy;
        let b = &ox * &dx + &oy * &dy;
        let c = &ox * &ox + &oy * &oy;
        let k = &ox * &dy - &oy * &dx;
        let dz2 = &dz * &dz;
        let b_dz = &b * &dz;
        let f = [
            &a * &lift * &lift,
            (&b_dz - &a * &oz) * &lift * IBig::from(2),
            &a * &oz * &oz - &b_dz * &oz * IBig::from(2) + &dz2 * &c,
            -(&dz2 * &lift * &lift),
        ];
        let speed2 = &a + &dz2;
        let flatness = ((bits(&speed2) + 1) / 2 - bits(&dz)).max(0);
        let unit_direction = -(bits(&speed2) / 2);
        Self {
            speed: to_f64(&speed2, 2 * unit_direction).sqrt(),
            t_exponent: unit - line.direction_exponent,
            a,
            b,
            c,
            k,
            oz,
            dz,
            lift,
            f,
            flatness,
            scale: line.scale.clone(),
            unit: unit - line.scale_exponent,
            unit_direction,
        }
    }

    fn polynomial(&self, piece: &Piece) -> Vec<IBig> {
        let [zz, zq, qq, rr] = &piece.squares;
        let [f0, f1, f2, f3] = &self.f;
        let constant = f2 * &qq[0];
        (0..zz.len())
            .map(|i| {
                let last = if piece.polynomial { constant.clone() } else { f2 * &qq[i] };
                f0 * &zz[i] + f1 * &zq[i] + f3 * &rr[i] + last
            })
            .collect()
    }

    /// Whether |dz| < 2^-`LEVEL_BITS` |d|.
    fn is_all_but_level(&self) -> bool {
        self.dz == IBig::ZERO || self.flatness > LEVEL_BITS
    }

    /// How far above the line, where it is closest to the axis, a point of the profile lies.
    fn below(&self, at: &Place) -> f64 {
        let low = &at.height * &self.a + &self.b * &self.dz * &at.q;
        self.length(&low, &(&self.a * &at.q))
    }

    /// The length `numerator / denominator` in the object's frame.
    fn length(&self, numerator: &IBig, denominator: &IBig) -> f64 {
        ratio_f64(numerator, &(denominator * &self.scale), self.unit)
    }

    /// The squared length `numerator / denominator` in the object's frame.
    fn area(&self, numerator: &IBig, denominator: &IBig) -> f64 {
        ratio_f64(numerator, &(denominator * &self.scale * &self.scale), 2 * self.unit)
    }

    /// A product of a length and the scaled direction.
    fn along(&self, numerator: &IBig, denominator: &IBig) -> f64 {
        ratio_f64(numerator, &(denominator * &self.scale), self.unit + self.unit_direction)
    }

    fn target(&self) -> i64 {
        PARAMETER_BITS + self.flatness
    }

    fn limit(&self) -> i64 {
        PARAMETER_BITS + 64 + 2 * self.flatness
    }
}

impl Oracle {
    /// Prepares a profile.
    pub fn new(profile: &Profile) -> Self {
        Self { pieces: Pieces::new(profile) }
    }

    /// The larger of the profile's largest radius and its extent along the axis.
    pub fn size(&self) -> f64 {
        self.pieces.size
    }

    /// The middle of the object, on the axis.
    pub fn center(&self) -> Vec3 {
        Vec3::new(0.0, 0.0, self.pieces.center)
    }

    /// All hits of the whole line of a ray, in order of t; its range does not matter.
    pub fn hits(&self, ray: &Ray) -> Vec<OracleHit> {
        self.hits_of_line(&ExactLine::new(ray))
    }

    /// All hits of the whole line, in order of t.
    pub fn hits_of_line(&self, line: &ExactLine) -> Vec<OracleHit> {
        let setup = Setup::new(line, self.pieces.exponent);
        let mut hits = Vec::new();
        for piece in &self.pieces.list {
            // A piece on the axis: F >= 0.
            if piece.controls[0].iter().all(|r| *r == IBig::ZERO) {
                continue;
            }
            if setup.dz == IBig::ZERO {
                self.level_hits(&setup, piece, &mut hits);
                continue;
            }
            let f = setup.polynomial(piece);
            for bracket in isolate(&f, setup.target(), setup.limit()) {
                if bracket.changes % 2 == 1 {
                    hits.push(self.steep_hit(&setup, piece, &bracket));
                }
            }
        }
        hits.sort_by(|x, y| {
            let (x, y) = (x.t, y.t);
            x.hi.total_cmp(&y.hi).then(x.lo.total_cmp(&y.lo))
        });
        hits
    }

    fn steep_hit(&self, setup: &Setup, piece: &Piece, bracket: &Bracket) -> OracleHit {
        let at = Place::new(piece, bracket, setup);
        let t = ratio(&at.height, &(&setup.dz * &at.q), setup.t_exponent);
        // a t + b = (a (Z - oz q) + b dz q) / (dz q)
        let along = &setup.a * &at.height + &setup.b * &setup.dz * &at.q;
        let along = setup.along(&along, &(&setup.dz * &at.q));
        self.hit(setup, piece, at, bracket, t, along)
    }

    /// Hits of a line perpendicular to the axis.
    fn level_hits(&self, setup: &Setup, piece: &Piece, hits: &mut Vec<OracleHit>) {
        for bracket in
            isolate(&height_polynomial(setup, piece), PARAMETER_BITS, PARAMETER_BITS + 64)
        {
            if bracket.changes % 2 == 0 {
                continue;
            }
            let at = Place::new(piece, &bracket, setup);
            // disc / q^2 = a r^2 - k^2
            let radius = &at.r * &setup.lift;
            let disc = &setup.a * &radius * &radius - &setup.k * &setup.k * &at.q * &at.q;
            if disc <= IBig::ZERO {
                continue;
            }
            let root = sqrt(&(disc << 512));
            for sign in [-1, 1] {
                let signed = &root * IBig::from(sign);
                let numerator = signed.clone() - ((&setup.b * &at.q) << 256);
                let t = ratio(&numerator, &((&setup.a * &at.q) << 256), setup.t_exponent);
                let along = setup.along(&signed, &(&at.q << 256));
                let at = Place::new(piece, &bracket, setup);
                hits.push(self.hit(setup, piece, at, &bracket, t, along));
            }
        }
    }

    fn hit(
        &self,
        setup: &Setup,
        piece: &Piece,
        at: Place,
        bracket: &Bracket,
        t: Double,
        along: f64,
    ) -> OracleHit {
        let unit = self.pieces.exponent;
        let [r, z] = [&at.r, &at.z].map(|x| ratio_f64(x, &at.q, unit));
        let dz = to_f64(&setup.dz, setup.unit_direction);
        // n.d for the normal (z' x/r, z' y/r, -r'), where x dx + y dy = a t + b.
        let radial = if r > 0.0 { along / r } else { setup.speed };
        let incidence = |(tr, tz): (f64, f64)| {
            let sine = (tz * radial - tr * dz).abs() / (tr.hypot(tz) * setup.speed);
            if sine.is_finite() { sine.min(1.0) } else { 0.0 }
        };
        let ends = [0, piece.controls[0].len() - 1].map(|i| {
            let q = to_f64(&piece.controls[2][i], 0);
            let [er, ez] = [0, 1].map(|c| to_f64(&piece.controls[c][i], unit) / q);
            (r - er).hypot(z - ez) / self.pieces.size
        });
        let own = incidence(at.tangent(piece));
        let tangent = |piece: &Piece, end: usize| {
            Place::at(piece, IBig::from(end as i64), 0, setup).tangent(piece)
        };
        let beyond = |end: usize| {
            let next =
                self.beyond(piece, end).map_or(1.0, |(next, end)| incidence(tangent(next, end)));
            if !piece.ends_on_axis(end) {
                return next;
            }
            // Beyond a pole the piece goes on as its mirror image.
            let (tr, tz) = tangent(piece, end);
            next.min(incidence((-tr, tz)))
        };
        let joint_incidence = if piece.is_speck {
            beyond(0).min(beyond(1))
        } else {
            own.min(beyond(usize::from(ends[1] < ends[0])))
        };
        let (x, m) = bracket.middle();
        let local = to_f64(&x, -m);
        OracleHit {
            t,
            segment: piece.segment,
            s: piece.segment_parameter(local),
            incidence: own,
            joint_incidence,
            joint_distance: ends[0].min(ends[1]),
            changes: bracket.changes,
        }
    }

    /// The piece beyond one end of another, specks left out, and its end there.
    fn beyond(&self, piece: &Piece, end: usize) -> Option<(&Piece, usize)> {
        let mut other = &self.pieces.list[piece.neighbours[end]?];
        // A closed chain may consist of specks alone.
        for _ in 0..self.pieces.list.len() {
            if !other.is_speck {
                return Some((other, 1 - end));
            }
            other = &self.pieces.list[other.neighbours[end]?];
        }
        None
    }

    /// How near the line of a ray is to having another number of hits, as a fraction of the object's
    /// size: the smallest distance, to first order and in the half plane, between the line's
    /// meridian and a point of the profile where F has an extremum, inside a piece, at a joint, or at
    /// an end of an open profile. Moving the line by less than this changes no count.
    pub fn tangency(&self, ray: &Ray) -> f64 {
        self.tangency_of_line(&ExactLine::new(ray))
    }

    /// The same for a line in an object's frame.
    pub fn tangency_of_line(&self, line: &ExactLine) -> f64 {
        let setup = Setup::new(line, self.pieces.exponent);
        let level = setup.dz == IBig::ZERO;
        let polynomials: Vec<_> = self
            .pieces
            .list
            .iter()
            .map(|p| if level { height_polynomial(&setup, p) } else { setup.polynomial(p) })
            .collect();
        let mut nearest = f64::INFINITY;
        for (index, (piece, f)) in self.pieces.list.iter().zip(&polynomials).enumerate() {
            let slope = derivative(f);
            if slope.len() > 1 {
                for bracket in isolate(&slope, setup.target(), PARAMETER_BITS + setup.flatness) {
                    let (x, m) = bracket.middle();
                    nearest = nearest.min(self.distance(&setup, piece, x, m));
                }
            }
            if level {
                for bracket in isolate(f, PARAMETER_BITS, PARAMETER_BITS) {
                    nearest = nearest.min(self.turning_distance(&setup, piece, &bracket));
                }
            }
            if setup.is_all_but_level() {
                let f = radius_polynomial(&setup, piece);
                for bracket in isolate(&f, PARAMETER_BITS, PARAMETER_BITS) {
                    nearest = nearest.min(setup.below(&Place::new(piece, &bracket, &setup)).abs());
                }
            }
            for (end, neighbour) in piece.neighbours.iter().enumerate() {
                let at_axis = piece.ends_on_axis(end);
                let turns = match neighbour {
                    Some(other) => {
                        let (one, two) =
                            (slope_at(f, end == 0), slope_at(&polynomials[*other], end != 0));
                        one * two <= 0
                    }
                    None => !at_axis,
                };
                if turns {
                    nearest = nearest.min(self.distance(&setup, piece, IBig::from(end as i64), 0));
                }
                let rises = |i: usize, start: bool| {
                    slope_at(&height_polynomial(&setup, &self.pieces.list[i]), start)
                };
                let flat = setup.is_all_but_level()
                    && neighbour.is_none_or(|n| rises(index, end == 0) * rises(n, end != 0) <= 0);
                if flat {
                    nearest = nearest.min(self.level_distance(&setup, piece, end));
                }
                if at_axis {
                    nearest = nearest.min(self.pole_distance(&setup, piece, end));
                }
            }
        }
        nearest / self.pieces.size
    }

    /// The distance of one point of the profile from the line's meridian.
    fn distance(&self, setup: &Setup, piece: &Piece, x: IBig, m: i64) -> f64 {
        let at = Place::at(piece, x, m, setup);
        let r = ratio_f64(&at.r, &at.q, self.pieces.exponent);
        if setup.dz == IBig::ZERO {
            let closest = setup.area(&(&setup.k * &setup.k), &setup.a).sqrt();
            return setup.length(&at.height, &at.q).hypot((closest - r).max(0.0));
        }
        let value = at.residual(setup);
        // w - r^2 = F / (dz q)^2
        let dz_q = &setup.dz * &at.q;
        let excess = setup.area(&value, &(&dz_q * &dz_q));
        if excess.is_infinite() {
            // All but level, and at the point's height as good as infinitely far away.
            return setup.length(&at.height, &at.q).abs();
        }
        let rho = (r * r + excess).max(0.0).sqrt();
        let along = &setup.a * &at.height + &setup.b * &setup.dz * &at.q;
        // d rho / d z along the line.
        let along = setup.along(&along, &dz_q);
        let dz = to_f64(&setup.dz, setup.unit_direction);
        let gap = excess.abs() / (rho + r);
        let steepness = (dz * rho).abs();
        if gap == 0.0 { 0.0 } else { gap * steepness / steepness.hypot(along) }
    }

    /// The distance between the line and a pole in space, if moving the line across the pole can
    /// change the number of hits: if it is no steeper than the cone that touches the surface there,
    /// by a margin within which the surface is taken for that cone.
    fn pole_distance(&self, setup: &Setup, piece: &Piece, end: usize) -> f64 {
        let at = Place::at(piece, IBig::from(end as i64), 0, setup);
        // The direction of a speck says nothing.
        let (tr, tz) = match self.beyond(piece, 1 - end).filter(|_| piece.is_speck) {
            Some((other, end)) => Place::at(other, IBig::from(end as i64), 0, setup).tangent(other),
            None => at.tangent(piece),
        };
        let dz = to_f64(&setup.dz, setup.unit_direction);
        let across = to_f64(&setup.a, 2 * setup.unit_direction).sqrt();
        if dz.abs() * tr.abs() > across * (tz.abs() + CONE_MARGIN * (tz.abs() + tr.abs())) {
            return f64::INFINITY;
        }
        // |(p - o) x d|^2 = k^2 + a h^2 + 2 b h dz + c dz^2, where p - o = (-ox, -oy, h).
        let h = &at.height;
        let q2 = &at.q * &at.q;
        let squared = (&setup.k * &setup.k + &setup.c * &setup.dz * &setup.dz) * &q2
            + &setup.a * h * h
            + &setup.b * h * &setup.dz * &at.q * IBig::from(2);
        let speed2 = &setup.a + &setup.dz * &setup.dz;
        setup.area(&squared, &(speed2 * q2)).sqrt()
    }

    /// For a line that is all but level: how far above or below a point where z turns it passes the
    /// circle of that point, or if it passes outside, the distance to where it is closest to the axis.
    ///
    /// A line that is higher or lower by this much may cross one part less on its way in and another
    /// part less on its way out.
    fn level_distance(&self, setup: &Setup, piece: &Piece, end: usize) -> f64 {
        let at = Place::at(piece, IBig::from(end as i64), 0, setup);
        let r = ratio_f64(&at.r, &at.q, self.pieces.exponent);
        // All relative to the point closest to the axis, where t = -b/a.
        let below = setup.below(&at);
        let closest = setup.area(&(&setup.k * &setup.k), &setup.a).sqrt();
        let across = to_f64(&setup.a, 2 * setup.unit_direction).sqrt();
        let tilt = to_f64(&setup.dz, setup.unit_direction).abs() / across;
        let reach = ((r - closest) * (r + closest)).max(0.0).sqrt() * tilt;
        (below.abs() - reach).abs().hypot((closest - r).max(0.0))
    }

    /// For a level line: how far its meridian, which ends at the line's distance from the axis, ends before or
    /// behind the profile. Beside a profile that is all but level this is much less than the difference of
    /// the radii: a line a little higher meets it at another radius.
    fn turning_distance(&self, setup: &Setup, piece: &Piece, bracket: &Bracket) -> f64 {
        let at = Place::new(piece, bracket, setup);
        let radius = &at.r * &setup.lift;
        let disc = &setup.a * &radius * &radius - &setup.k * &setup.k * &at.q * &at.q;
        let excess = setup.area(&disc, &(&setup.a * &at.q * &at.q));
        let r = ratio_f64(&at.r, &at.q, self.pieces.exponent);
        let rho = (r * r - excess).max(0.0).sqrt();
        let (tr, tz) = at.tangent(piece);
        let slope = tz.abs() / tr.hypot(tz);
        let slope = if slope.is_nan() { 1.0 } else { slope };
        if excess == 0.0 { 0.0 } else { excess.abs() / (r + rho) * slope }
    }
}

/// Z - oz q in the Bernstein basis.
fn height_polynomial(setup: &Setup, piece: &Piece) -> Vec<IBig> {
    let [_, z, q] = &piece.controls;
    z.iter().zip(q).map(|(z, q)| z * &setup.lift - &setup.oz * q).collect()
}

/// a R^2 - k^2 q^2 in the Bernstein basis: 0 where the profile is as far from the axis as the line is at its
/// closest. By the height that the line lacks there it may be raised to end on the profile.
fn radius_polynomial(setup: &Setup, piece: &Piece) -> Vec<IBig> {
    let [_, _, qq, rr] = &piece.squares;
    let (of_r, of_q) = (&setup.a * &setup.lift * &setup.lift, &setup.k * &setup.k);
    let q = |i: usize| if piece.polynomial { &qq[0] } else { &qq[i] };
    rr.iter().enumerate().map(|(i, rr)| &of_r * rr - &of_q * q(i)).collect()
}

/// The sign of the slope at one end of a piece; 0 for a constant.
fn slope_at(f: &[IBig], start: bool) -> i32 {
    let order: Vec<&IBig> = if start { f.iter().collect() } else { f.iter().rev().collect() };
    let Some(next) = order.iter().find(|x| **x != order[0]) else { return 0 };
    let sign = if *next > order[0] { 1 } else { -1 };
    if start { sign } else { -sign }
}

/// A point of a piece: r q, z q and q there, multiplied by one power of two.
struct Place {
    r: IBig,
    z: IBig,
    q: IBig,
    /// (Z - oz q) in the line's unit.
    height: IBig,
    x: IBig,
    m: i64,
}

impl Place {
    fn new(piece: &Piece, bracket: &Bracket, setup: &Setup) -> Self {
        let (x, m) = bracket.middle();
        Self::at(piece, x, m, setup)
    }

    fn at(piece: &Piece, x: IBig, m: i64, setup: &Setup) -> Self {
        let [r, z, q] = piece.power.each_ref().map(|p| evaluate(p, &x, m));
        let height = &z * &setup.lift - &setup.oz * &q;
        Self { r, z, q, height, x, m }
    }

    /// F here, times the same power of two squared.
    fn residual(&self, setup: &Setup) -> IBig {
        let [f0, f1, f2, f3] = &setup.f;
        f0 * &self.z * &self.z
            + f1 * &self.z * &self.q
            + f2 * &self.q * &self.q
            + f3 * &self.r * &self.r
    }

    /// The direction (r', z') of the profile, of any length.
    fn tangent(&self, piece: &Piece) -> (f64, f64) {
        let [r, z, q] = piece.slope.each_ref().map(|p| evaluate(p, &self.x, self.m));
        let (r, z) = if piece.polynomial {
            (r, z)
        } else {
            (&r * &self.q - &self.r * &q, &z * &self.q - &self.z * &q)
        };
        let scale = -bits(&r).max(bits(&z));
        (to_f64(&r, scale), to_f64(&z, scale))
    }
}
