//! x
use rondure::*;
use rondure::engine::*;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let set = std::env::args().nth(2).unwrap();
    let surface = Surface::with_engine(&Profile::from_path_data(&std::fs::read_to_string(path).unwrap()).unwrap(), &EngineOptions { instructions: if std::env::args().nth(3).is_some() {Instructions::Avx512} else {Instructions::Avx2}, ..Default::default() });
    let rays = if set == "camera" { camera_rays() } else { random_rays(&surface.bounds()) };
    let n = rays.len();
    let mut s = 0.0;
    let rounds = if std::env::args().nth(5).is_some() {1} else if std::env::args().nth(3).is_some() {100} else {1};
    let rays: Vec<Ray> = if std::env::args().nth(5).is_some() { rays.into_iter().step_by(24).collect() } else { rays };
    let b = surface.bounds();
    let rm = b.max.x;
    let class = |r: &Ray| { if surface.closest(r).is_some() { return "hit"; } let k = r.origin.x*r.direction.y - r.origin.y*r.direction.x; if k*k > (r.direction.x.powi(2)+r.direction.y.powi(2))*rm*rm { "out" } else { "near" } };
    let rays: Vec<Ray> = if let Some(c) = std::env::args().nth(4) { rays.into_iter().filter(|r| class(r) == c).collect()} else {rays};
    let start = cpu_time::ThreadTime::now();
    let col = |f: &dyn Fn(&Ray) -> f64| rays.iter().map(f).collect::<Vec<f64>>();
    let (ox, oy, oz, dx, dy, dz, t0, t1) = (col(&|r| r.origin.x), col(&|r| r.origin.y), col(&|r| r.origin.z), col(&|r| r.direction.x), col(&|r| r.direction.y), col(&|r| r.direction.z), col(&|r| r.t_min), col(&|r| r.t_max));
    let soa = Rays::new([&ox, &oy, &oz], [&dx, &dy, &dz], &t0, &t1).unwrap();
    let mut hits = Hits::default();
    let b0 = cpu_time::ThreadTime::now();
    for _ in 0..rounds { surface.closest_of_many(&soa, &mut hits); }
    println!("batch {} ns {}", b0.elapsed().as_secs_f64()*1e9/(rounds*rays.len()) as f64, hits.t.iter().filter(|t| t.is_finite()).sum::<f64>());
    let start = cpu_time::ThreadTime::now();
    for _ in 0..rounds { s = run(&surface, &rays); }
    println!("{n} {s} {} ns", start.elapsed().as_secs_f64()*1e9/(rounds*rays.len()) as f64);
}
#[inline(never)]
fn run(surface: &Surface, rays: &[Ray]) -> f64 {
    let mut s = 0.0;
    for r in rays { if let Some(h) = surface.closest(r) { s += h.t; } }
    s
}
fn camera_rays() -> Vec<Ray> {
    let (width, height) = (128,96);
    let eye = Vec3::new(1.30, 0.45, 0.95);
    let forward = (Vec3::new(0.0, 0.0, 0.48) - eye).normalized();
    let right = forward.cross(Vec3::Z).normalized();
    let up = right.cross(forward);
    let scale = 23.0_f64.to_radians().tan() / (0.5 * f64::from(height));
    let ray = |i: i32| {
        let x = f64::from(i % width) + 0.5 - 0.5 * f64::from(width);
        let y = 0.5 * f64::from(height) - f64::from(i / width) - 0.5;
        Ray::new(eye, forward + right * (x * scale) + up * (y * scale))
    };
    (0..width * height).map(ray).collect()
}

fn random_rays(bounds: &Bounds) -> Vec<Ray> {
    let mut state = 1_u64;
    let mut number = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut vector = || Vec3::new(number(), number(), number());
    let (center, extent) = (bounds.center(), bounds.extent());
    let radius = 0.5 * extent.length();
    let ray = |_| {
        let origin = center + (vector() - Vec3::splat(0.5)).normalized() * radius;
        let v = vector();
        let target = bounds.min + Vec3::new(extent.x * v.x, extent.y * v.y, extent.z * v.z);
        Ray::new(origin, target - origin)
    };
    (0..1 << 14).map(ray).collect()
}
