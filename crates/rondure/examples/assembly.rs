//! What a ray costs in scenes of a hundred to ten million instances, as a Markdown table:
//! `cargo run --release -p rondure --example assembly --features parallel -- [MOST]`
//!
//! The scene is a cubic lattice of vases of a hundred shapes, each turned, scaled and moved a little
//! at random. Camera rays come from a pinhole outside in scanline order, random rays run from
//! the sphere round the box to a point in the box. Batches take camera rays, those of squares of four by four
//! pixels together. One thread, the best of the rounds.

mod rays;

use std::{env, error::Error, sync::Arc, time::Instant};

use rondure::{
    Affine, Assembly, Bounds, Contacts, Instances, Profile, Ray, RayColumns, Surface, Vec3,
};

use self::rays::{Random, pinhole, random_rays};

const SHAPES: u32 = 100;
const ROUNDS: usize = 5;
const WIDTH: u32 = 1024;
const HEIGHT: u32 = 768;

fn main() -> Result<(), Box<dyn Error>> {
    let most = env::args().nth(1).map_or(Ok(10_000_000), |text| text.parse())?;
    println!(
        "| instances | build, s | bytes each | camera, ns a ray | random, ns a ray | \
         camera, any | random, any | camera, batch | camera, any, batch | camera hits | random hits |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut count = 1;
    while count <= most {
        let start = Instant::now();
        let assembly = lattice(count)?;
        let seconds = start.elapsed().as_secs_f64();
        let bounds = assembly.bounds();
        let sets = [camera_rays(&bounds), random_rays(&bounds, 1 << 18)];
        let [camera, random] = [&sets[0], &sets[1]].map(|rays| {
            let count = |hit: &dyn Fn(&Ray) -> bool| rays.iter().filter(|ray| hit(ray)).count();
            let closest = best(rays, || count(&|ray| assembly.closest(ray).is_some()));
            (closest, best(rays, || count(&|ray| assembly.any(ray))).0)
        });
        let columns = RayColumns::from_iter(&tiles(&sets[0]));
        let (mut contacts, mut hits) = (Contacts::default(), vec![false; sets[0].len()]);
        let batch = best(&sets[0], || {
            assembly.closest_of_many(&columns.rays(), &mut contacts);
            contacts.hits.t.iter().filter(|t| t.is_finite()).count()
        });
        let any_batch = best(&sets[0], || {
            assembly.any_of_many(&columns.rays(), &mut hits);
            hits.iter().filter(|hit| **hit).count()
        });
        println!(
            "| {count} | {seconds:.2} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} % | {:.0} % |",
            assembly.bytes() as f64 / count as f64,
            camera.0.0,
            random.0.0,
            camera.1,
            random.1,
            batch.0,
            any_batch.0,
            camera.0.1,
            random.0.1,
        );
        count *= if count == 1 { 100 } else { 10 };
    }
    Ok(())
}

/// Nanoseconds a ray in the best round, and how many in a hundred hit.
fn best(rays: &[Ray], mut count: impl FnMut() -> usize) -> (f64, f64) {
    let rounds = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        let hits = count();
        let rays = rays.len() as f64;
        (start.elapsed().as_secs_f64() * 1e9 / rays, 100.0 * hits as f64 / rays)
    });
    rounds.fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a })
}

/// A vase of height 1; the first is that of `profiles/vase.path`.
fn vase(shape: u32) -> Result<Surface, Box<dyn Error>> {
    let mut random = Random(u64::from(shape));
    let mut radius = |mean: f64| {
        if shape == 0 { mean } else { mean * (0.6 + 0.8 * random.number()) }
    };
    let [foot, belly, neck, lip] = [0.16, 0.3, 0.1, 0.18].map(&mut radius);
    let path = format!(
        "M 0 0 L {foot} 0 C {} 0.15 {belly} 0.25 {belly} 0.42 C {belly} 0.6 {neck} 0.65 {neck} 0.8 \
         C {neck} 0.88 {} 0.95 {lip} 1",
        foot + 0.05,
        lip - 0.04
    );
    Ok(Surface::new(&Profile::from_path_data(&path)?))
}

fn lattice(count: usize) -> Result<Assembly, Box<dyn Error>> {
    let mut instances = Instances::new();
    for shape in 0..SHAPES {
        instances.add_shape(Arc::new(vase(shape)?));
    }
    instances.try_reserve(count)?;
    let mut random = Random(1);
    let side = (count as f64).cbrt().ceil() as usize;
    for i in 0..count {
        let cell = [i % side, i / side % side, i / side / side].map(|c| c as f64);
        let place = Vec3::new(cell[0], cell[1], cell[2]) + random.vector() * 0.5;
        let axis = random.vector() - Vec3::splat(0.5);
        let placement = Affine::translate(place)
            .after(&Affine::rotate(axis, 6.0 * random.number()))
            .after(&Affine::scale(Vec3::splat(0.4 + 0.6 * random.number())));
        instances.place(i as u32 % SHAPES, placement)?;
    }
    Ok(Assembly::new(instances)?)
}

/// A pinhole from outside.
fn camera_rays(bounds: &Bounds) -> Vec<Ray> {
    let (center, radius) = (bounds.center(), 0.5 * bounds.extent().length());
    let eye = center + Vec3::new(2.0, -1.3, 1.1).normalized() * (2.2 * radius);
    pinhole([eye, center], 20.0, [WIDTH, HEIGHT])
}

/// The same rays, but those of squares of four by four pixels after each other.
fn tiles(rays: &[Ray]) -> Vec<Ray> {
    let at = |x: u32, y: u32| rays[(y * WIDTH + x) as usize];
    let corners = (0..HEIGHT).step_by(4).flat_map(|y| (0..WIDTH).step_by(4).map(move |x| (x, y)));
    corners.flat_map(|(x, y)| (0..16).map(move |i| at(x + i % 4, y + i / 4))).collect()
}
