//! Rays that an engine once got wrong, each named after its cause.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use rondure::{EngineOptions, Method, Profile, Ray, Surface, Vec3};
use rondure_oracle::{ExactLine, Oracle, Random, Tally, compare::TANGENCY_BAND};

#[track_caller]
fn check(path: &str, ray: Ray) {
    let profile = Profile::from_path_data(path).unwrap();
    let mut tally = Tally::default();
    tally.compare(&Surface::new(&profile), &Oracle::new(&profile), &ray, profile.bounds_solid());
    tally.assert_clean();
    assert_eq!(tally.tangent, 0);
}

/// 1/dz is minus infinity although dz >= 0, and near and far planes change places.
#[test]
fn direction_with_a_negative_zero() {
    let level = Vec3::new(0.125, 0.0, -0.0);
    check("M 1.5 0 L 0 -1", Ray::line(Vec3::new(0.0, 0.25, -0.5), level));
}

/// Halving leaves errors in X of the size of X itself, and made three hits out of one.
#[test]
fn all_but_level_through_the_widest_place() {
    let d = Vec3::new(1.0, 0.0, -1e-17);
    check("M 0 0 C 0.7 0 1 0.5 1 1 C 1 1.6 0.6 2 0 2", Ray::line(Vec3::new(-3.0, 0.1, 1.0), d));
}

/// F is rounding noise beside the corner that the ray passes through: the search for the other root must
/// not settle there.
#[test]
fn root_beside_a_corner_on_the_ray() {
    let origin = Vec3::new(2.4103727820860845, 0.7684288213418137, -1.1917909892602767);
    let direction = Vec3::new(-0.7051863910430423, -0.38421441067090684, 0.5958954946301384);
    check("M 0 0 C 2 1 -0.2 1 1 0 L 1 -1 L 0 -1", Ray::line(origin, direction));
}

/// Where the ray is all but level and grazes, t is neither a quotient by dz nor a root of noise.
#[test]
fn all_but_level_and_grazing() {
    let path = "M 0 -1.4464530577120776 L 1.0000000000000007 0.25 Q 0.5 0.5 0 0.25";
    let ray = Ray::line(
        Vec3::new(1.0, -0.705768414751985, 0.25),
        Vec3::new(0.0, -2.0, -8.881784197001252e-16),
    );
    let profile = Profile::from_path_data(path).unwrap();
    let surface = Surface::new(&profile);
    let mut hits = Vec::new();
    surface.all(&ray, &mut hits);
    assert!(hits.len().is_multiple_of(2));
    for hit in hits {
        // The surface is met within 1e-7 of the closest approach to the axis, or missed.
        assert!((hit.t + 0.3528842).abs() < 1e-6, "{hit:?}");
    }
}

/// Both roots on a needle are nearly one in s, not in t.
#[test]
fn across_a_needle() {
    check("M 0 1 L 1e-8 -1", Ray::line(Vec3::ZERO, Vec3::new(0.0, 0.25, 0.25)));
}

/// On a short edge the discriminant lost R / length in digits, and two grazing hits moved by the tenth part of
/// the edge.
#[test]
fn grazing_a_short_edge() {
    let ray = Ray::line(
        Vec3::new(0.06277411259526638, 0.3184338269868024, 2.0978381186967026),
        Vec3::new(-0.005969966559499218, -0.0009099880187887651, -0.9999817655442944),
    );
    let polyline = rondure_oracle::agree::shapes().unwrap();
    let polyline = &polyline.iter().find(|s| s.name == "polyline").unwrap().profile;
    let mut tally = Tally::default();
    tally.compare(&Surface::new(polyline), &Oracle::new(polyline), &ray, true);
    tally.assert_clean();
    assert!(tally.worst_forward < 1e-8, "{tally}");
}

/// Beside a joint where the ray touches the cone beyond it, value, slope and discriminant of F are rounding that
/// do not fit each other, and their quotient was any number.
#[test]
fn grazing_a_cone_beside_its_joint() {
    let path = "M 0 0.00012521880587231971 Q 9.214181329261335e-5 4.5314511878019437e-5 \
                6.260940293615988e-5 0 Z";
    let origin = Vec3::new(0.00028865503322854716, -0.00018284894952030165, 3.6270402410806666e-5);
    let direction = Vec3::new(-0.9231639842497427, 0.36941640463493947, -0.10630041472513437);
    check(path, Ray::line(origin, direction));
}

/// Far from the origin the ends of pieces, where r or z turns, were rounded to the last place of z.
#[test]
fn a_curve_far_up_the_axis() {
    let path = "M 0 -28115.965390963123 C 0.264180331626542 -28115.78445664467 \
                0.18112493846199687 -28115.788275495248 0.1792844082274167 -28115.75798348114 \
                C 0.15725009232126244 -28115.74744970403 0.13328606387029981 -28115.788855182338 \
                0 -28115.706689493225";
    let profile = Profile::from_path_data(path).unwrap();
    let mut tally = Tally { strict: true, ..Tally::default() };
    let (surface, oracle) = (Surface::new(&profile), Oracle::new(&profile));
    let mut random = Random::new(11);
    for _ in 0..20_000 {
        let line = random.line(oracle.center(), oracle.size());
        tally.compare(&surface, &oracle, &line, true);
    }
    tally.assert_clean();
    assert!(tally.worst_steep < 1e-14, "{tally}");
}

/// The hit of a line along a wall may lie anywhere on it, also behind another hit: hits and exact ones do
/// not go together in order.
#[test]
fn along_a_wall_and_through_another() {
    check(
        "M 0.1 0 L 0.09999999999999999 1.4025774787914227 Q 0.25 -2 0.1 0.10000000000000002",
        Ray::line(Vec3::new(8.881784197001252e-16, -0.1, 0.25), Vec3::new(-1e-17, -1e-17, -0.25)),
    );
}

/// What the oracle says about how near a line is to touching.
#[track_caller]
fn is_tangent(path: &str, ray: Ray) {
    let tangency = Oracle::new(&Profile::from_path_data(path).unwrap()).tangency(&ray);
    assert!(tangency <= TANGENCY_BAND, "{tangency:e}");
}

/// At the height of the crown the ray is so far away that the square of it overflows.
#[test]
fn all_but_level_beside_a_crown() {
    let top = Vec3::new(3.0, 0.1, 1.0 + f64::EPSILON);
    is_tangent("M 1 -1 A 1 1 0 0 1 1 1 Z", Ray::line(top, Vec3::new(-1.0, 0.0, -1e-200)));
}

/// A closed outline that touches the axis with a corner has a pole there like any other.
#[test]
fn through_the_pole_of_a_closed_outline() {
    let ray = Ray::line(Vec3::new(0.0, 0.0, 2.0), Vec3::new(0.55, 0.66, -0.5));
    is_tangent("M 0 2 Q 0.3 0 2 1 L 0 2", ray);
}

/// A level line meets a nearly level wall at a radius that depends on its height more than on anything
/// else: a hair higher it passes outside.
#[test]
fn level_beside_a_nearly_level_wall() {
    let path = "M 1 0 L 2 1e-14 L 2 -1 L 1 -1 Z";
    // At the height of r = 1.5, and 1e-8 beyond the circle.
    let ray = Ray::line(Vec3::new(-3.0, 1.5 - 1e-8, 0.5e-14), Vec3::X);
    is_tangent(path, ray);
}

/// A level line that passes a hair above the crown and a hair outside its circle touches when it is lowered by the one,
/// not moved by the other.
#[test]
fn level_above_a_crown_and_outside_it() {
    let above = Vec3::new(-3.0, 1.0 + 3e-10, 1.0 + f64::EPSILON);
    is_tangent("M 1 -1 A 1 1 0 0 1 1 1 Z", Ray::line(above, Vec3::X));
}

/// Through the pole F ends in what is all but a double root, and the search for the hit on the far wall of the
/// same piece stayed there.
#[test]
fn through_a_pole_and_the_wall_beyond() {
    let path = "M 0 -120009148505.41139 C 363816.6467570975 -120008824710.15956 \
                391954.9890130523 -120008650917.74838 282219.3551365168 -120008687373.08005 \
                C 207939.4064983108 -120008720503.44872 151735.69707857264 -120008799801.31174 \
                43688.24883387468 -120008866286.05626 C 88542.52569934078 -120008964969.32983 \
                228197.74976289086 -120008972309.42648 282219.35513651674 -120009049414.10843 \
                C 370174.13569393265 -120009038907.0326 448310.9587092113 -120008950913.95523 \
                0 -120008584066.70113";
    let origin = Vec3::new(0.0, -0.0, -120008584066.70113);
    let direction = Vec3::new(-0.6883017229026726, 0.2803926529828766, -0.6690446161523436);
    check(path, Ray::line(origin, direction));
}

/// Beside the axis rho^2 - r^2 bends as much as it slopes, and Newton's steps were taken for done too early: hits
/// were off by some 1e-14 of the size, and a ray beside the end of a piece hit it or not according to who was asked.
#[test]
fn close_to_the_axis() {
    let mut random = Random::new(4581);
    for _ in 0..100 {
        let radius = 10f64.powf(random.within(-5.0, -1.0));
        let path = format!("M {radius} 0.3 L 1 0.3 L 1 0.6 L {radius} 0.7 Z");
        let profile = Profile::from_path_data(&path).unwrap();
        let (surface, oracle) = (Surface::new(&profile), Oracle::new(&profile));
        let mut tally = Tally { strict: true, ..Tally::default() };
        for i in 0..100 {
            // Beside the joint, and farther out.
            let beside = radius * (1.0 + random.within(-4.0, 4.0) * f64::EPSILON);
            let out = radius * (1.0 + 10f64.powf(random.within(-4.0, 1.0)));
            let rho = if i % 2 == 0 { beside } else { out };
            let (sin, cos) = random.within(0.0, 6.3).sin_cos();
            let origin = Vec3::new(rho * cos, rho * sin, random.within(-1.0, 0.0));
            tally.compare(&surface, &oracle, &Ray::new(origin, Vec3::Z), true);
        }
        tally.assert_clean();
        assert!(tally.worst_steep < 1e-15, "{path}: {tally}");
    }
}

/// A line through a pole may as well hit the mirror image of the wall, which it all but runs along.
#[test]
fn through_a_pole_along_the_mirrored_wall() {
    let profile = Profile::from_path_data("M 0 1 L 1 0 L 0 -1").unwrap();
    let oracle = Oracle::new(&profile);
    let origin = Vec3::new(-2.0, 0.0, -1.0 - 2e-6 - 1e-10);
    let hits = oracle.hits(&Ray::line(origin, Vec3::new(1.0, 0.0, 1.0 + 1e-6)));
    let pole = hits.last().unwrap();
    assert!(pole.joint_distance < 1e-9 && pole.incidence > 0.9, "{pole:?}");
    assert!(pole.joint_incidence < 1e-6, "{pole:?}");
}

/// How far lines stray from a cylinder of radius and height 1: along its lid, its side, and its diagonal.
#[test]
fn straying_from_a_cylinder() {
    let oracle = Oracle::new(&Profile::from_path_data("M 0 0 L 1 0 L 1 1 L 0 1").unwrap());
    let straying = |origin, direction| {
        oracle.straying(&ExactLine::new(&Ray::line(origin, direction)), [-0.75, 0.75])
    };
    assert!(straying(Vec3::new(0.0, 0.0, 1.0), Vec3::X) < 1e-17);
    assert!(straying(Vec3::new(0.0, 0.5, 1.0 + 1e-13), Vec3::X) < 2e-13);
    let side = straying(Vec3::new(1e6 + 1.0 + 1e-9, 0.0, 0.5), Vec3::new(0.0, 0.0, 0.5));
    assert!((side - 1e6).abs() < 1e-3, "{side}");
    let side = straying(Vec3::new(0.6, 0.8, 0.5), Vec3::new(0.0, 0.0, 0.5));
    assert!(side < 1e-16, "{side}");
    let diagonal = straying(Vec3::new(0.0, 0.0, 0.5), Vec3::new(0.25, 0.0, 0.25));
    assert!((diagonal - 0.5).abs() < 1e-15, "{diagonal}");
}

/// A step of Newton's that ends just on the end of its bracket has found no root there.
#[test]
fn newton_onto_the_end_of_a_piece() {
    let path = "M 0 0 C 0.08451631245193558 -0.425639217084804 0.23574403699758806 0 \
                0.23574403699758806 -0.729358501937184 Q 0.235744036997588 0 \
                0.13589440081308868 -0.59288358167974 Z";
    let origin = Vec3::new(-0.6199547266466063, -0.8022943521309025, -0.8752302023246208);
    let direction = Vec3::new(0.5461186812727501, 0.7067418228235591, 0.44974479634226483);
    let profile = Profile::from_path_data(path).unwrap();
    let options = EngineOptions { method: Method::Exact, ..EngineOptions::default() };
    let surface = Surface::with_engine(&profile, &options);
    let mut tally = Tally::default();
    tally.compare(&surface, &Oracle::new(&profile), &Ray::line(origin, direction), true);
    tally.assert_clean();
}
