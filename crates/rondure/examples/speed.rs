//! How many rays a second one thread answers, on a profile given as a file of path data.

use std::time::Instant;

use rondure::{Profile, Ray, Surface, Vec3};

fn main() {
    for file in std::env::args().skip(1) {
        let text = std::fs::read_to_string(&file).unwrap();
        let surface = Surface::new(&Profile::from_path_data(&text).unwrap());
        let b = surface.bounds();
        let mut state = 1_u64;
        let mut random = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let radius = 0.5 * b.extent().length();
        let rays: Vec<Ray> = (0..1 << 18)
            .map(|_| {
                let d = Vec3::new(random() - 0.5, random() - 0.5, random() - 0.5).normalized();
                let o = b.center() + d * radius;
                let e = b.extent();
                let p = b.min + Vec3::new(e.x * random(), e.y * random(), e.z * random());
                Ray::new(o, p - o)
            })
            .collect();
        let eye = Vec3::new(1.30, 0.45, 0.95);
        let w = (Vec3::new(0.0, 0.0, 0.48) - eye).normalized();
        let u = w.cross(Vec3::Z).normalized();
        let v = u.cross(w);
        let k = (23.0_f64).to_radians().tan();
        let camera: Vec<Ray> = (0..768 * 1024)
            .map(|i| {
                let (x, y) = ((i % 1024) as f64 + 0.5, (i / 1024) as f64 + 0.5);
                let d = w + u * ((x - 512.0) / 384.0 * k) + v * ((384.0 - y) / 384.0 * k);
                Ray::new(eye, d)
            })
            .collect();
        for (name, set) in [("camera", &camera), ("random", &rays)] {
            let best = |count: &dyn Fn() -> usize| {
                let times = (0..7).map(|_| {
                    let start = Instant::now();
                    (start.elapsed().as_secs_f64(), count(), start.elapsed().as_secs_f64())
                });
                times.map(|(_, n, t)| (t, n)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
            };
            let (t, hits) = best(&|| set.iter().filter(|r| surface.closest(r).is_some()).count());
            let (t2, any) = best(&|| set.iter().filter(|r| surface.any(r)).count());
            assert_eq!(hits, any);
            println!(
                "{file} {name}: {:.2} M/s closest, {:.2} any, {:.1} % hit, {} pieces",
                set.len() as f64 / t * 1e-6,
                set.len() as f64 / t2 * 1e-6,
                100.0 * hits as f64 / set.len() as f64,
                surface.piece_count()
            );
        }
    }
}
