//! The sphere drawn as a profile, against its closed form, and the parity of a closed goblet; the
//! crate `rondure-oracle` has many more of the kind.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use rondure::{Hit, Profile, Ray, Surface, Vec3};

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * 2.0 - Vec3::splat(1.0)
    }
}

fn surface(path: &str) -> Surface {
    Surface::new(&Profile::from_path_data(path).unwrap())
}

fn ts(surface: &Surface, ray: &Ray) -> Vec<f64> {
    let mut hits: Vec<Hit> = Vec::new();
    surface.all(ray, &mut hits);
    hits.iter().map(|h| h.t).collect()
}

#[test]
fn sphere() {
    let sphere = surface("M 0 -1 A 1 1 0 0 1 0 1");
    let mut random = Random(1);
    let mut worst = 0.0_f64;
    for _ in 0..1_000_000 {
        let ray = Ray::line(random.vector() * 3.0, random.vector());
        let (o, d) = (ray.origin, ray.direction);
        let a = d.dot(d);
        let across = o.cross(d);
        let disc = a - across.dot(across);
        let expected = if disc > 0.0 {
            let root = disc.sqrt();
            vec![(-o.dot(d) - root) / a, (-o.dot(d) + root) / a]
        } else {
            vec![]
        };
        let found = ts(&sphere, &ray);
        assert_eq!(found.len(), expected.len(), "{ray:?} {disc}");
        for (f, e) in found.iter().zip(&expected) {
            worst = worst.max((f - e).abs() * a.sqrt());
        }
    }
    println!("sphere: worst {worst:e}");
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn goblet_is_hit_an_even_number_of_times() {
    let goblet = surface(include_str!("../../../profiles/goblet.path"));
    let mut random = Random(2);
    let mut hits = 0;
    for i in 0..1_000_000 {
        let mut d = random.vector();
        if i % 3 == 0 {
            d.z *= 1e-9;
        }
        let ray = Ray::line(Vec3::new(0.0, 0.0, 0.5) + random.vector() * 0.6, d);
        let n = ts(&goblet, &ray).len();
        assert!(n.is_multiple_of(2), "{n} hits on {ray:?}");
        hits += n;
    }
    println!("{hits} hits");
}
