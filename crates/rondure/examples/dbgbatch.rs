use rondure::*;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let reps: usize = a.get(1).map_or(5, |x| x.parse().unwrap());
    let only = a.get(2).cloned().unwrap_or_default();
    let text = std::fs::read_to_string(format!("profiles/{}.path", a[0])).unwrap();
    let p = Profile::from_path_data(&text).unwrap();
    let s = Surface::new(&p);
    let eye = Vec3::new(1.30, 0.45, 0.95);
    let fw = (Vec3::new(0.0, 0.0, 0.48) - eye).normalized();
    let right = fw.cross(Vec3::Z).normalized();
    let up = right.cross(fw);
    let (w, h) = (1024u32, 768u32);
    let scale = 23f64.to_radians().tan() / (0.5 * h as f64);
    let rays: Vec<Ray> = (0..w * h)
        .map(|i| {
            let (tile, packet, lane) = (i / 64, i / 16 % 4, i % 16);
            let tiles = w / 8;
            let c = tile % tiles * 8 + packet % 2 * 4 + lane % 4;
            let r = tile / tiles * 8 + packet / 2 * 4 + lane / 4;
            let x = c as f64 + 0.5 - 0.5 * w as f64;
            let y = 0.5 * h as f64 - r as f64 - 0.5;
            Ray::new(eye, fw + right * (x * scale) + up * (y * scale))
        })
        .collect();
    let hits: Vec<Ray> = rays.iter().filter(|r| s.any(r)).copied().collect();
    let mut st = 1u64;
    let mut rnd = move || {
        st = st.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (st >> 11) as f64 / (1u64 << 53) as f64
    };
    let b = s.bounds();
    let random: Vec<Ray> = (0..1 << 18)
        .map(|_| {
            let c = (b.min + b.max) * 0.5;
            let e = b.max - b.min;
            let d = loop {
                let v = Vec3::new(rnd() * 2.0 - 1.0, rnd() * 2.0 - 1.0, rnd() * 2.0 - 1.0);
                if v.length() < 1.0 && v.length() > 0.1 {
                    break v.normalized();
                }
            };
            let o = c + d * (0.5 * e.length());
            let t = b.min + Vec3::new(e.x * rnd(), e.y * rnd(), e.z * rnd());
            Ray::new(o, t - o)
        })
        .collect();
    let light = Vec3::new(1.5, -1.2, 2.2);
    let shadow: Vec<Ray> = hits
        .iter()
        .filter_map(|r| {
            let h = s.closest(r)?;
            let i = s.interaction(r, &h);
            let n = if i.normal.dot(r.direction) < 0.0 { i.normal } else { i.normal * -1.0 };
            let o = i.point + n * 1e-4;
            Some(Ray::new(o, light - o).with_range(0.0, 1.0))
        })
        .collect();
    for (name, rays) in
        [("camera", &rays), ("hits", &hits), ("random", &random), ("shadow", &shadow)]
    {
        if !name.contains(&only) {
            continue;
        }
        let cols = RayColumns::from_iter(rays.iter());
        let mut out = Hits::default();
        let mut best = [f64::INFINITY; 4];
        let mut any = vec![false; rays.len()];
        for _ in 0..reps {
            let t = Instant::now();
            s.closest_of_many(&cols.rays(), &mut out);
            best[0] = best[0].min(t.elapsed().as_secs_f64());
            let t = Instant::now();
            let mut n = 0;
            for r in rays {
                n += usize::from(s.closest(r).is_some());
            }
            std::hint::black_box(n);
            best[1] = best[1].min(t.elapsed().as_secs_f64());
            let t = Instant::now();
            s.any_of_many(&cols.rays(), &mut any);
            best[2] = best[2].min(t.elapsed().as_secs_f64());
            let t = Instant::now();
            let mut n = 0;
            for r in rays {
                n += usize::from(s.any(r));
            }
            std::hint::black_box(n);
            best[3] = best[3].min(t.elapsed().as_secs_f64());
        }
        let m = |t: f64| rays.len() as f64 / t / 1e6;
        println!(
            "{} {name}: closest batch {:.1} single {:.1}; any batch {:.1} single {:.1} Mrays/s",
            a[0],
            m(best[0]),
            m(best[1]),
            m(best[2]),
            m(best[3])
        );
    }
}
