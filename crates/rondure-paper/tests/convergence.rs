//! Pictures on frusta come nearer to the exact picture with the square of the number of samples.

use rondure::{EngineOptions, Method};
use rondure_paper::scenes;
use rondure_render::{Picture, Settings, render};
use rondure_scene::Integrator;

fn channels(picture: &Picture) -> Vec<f64> {
    picture.pixels().iter().flatten().map(|v| f64::from(*v)).collect()
}

/// The mean absolute difference of the channels, where the two pictures show the same things.
///
/// On the few pixels that an outline or the edge of a shadow crosses, a sample sees one thing in one
/// picture and another thing in the other. How many there are falls with the square, too, but in
/// whole numbers: a test could not tell the slope from chance.
fn difference(a: &Picture, b: &Picture) -> f64 {
    const ANOTHER_THING: f64 = 0.02;
    let pairs: Vec<f64> = channels(a).iter().zip(channels(b)).map(|(a, b)| (a - b).abs()).collect();
    let same: Vec<f64> = pairs.iter().copied().filter(|d| *d < ANOTHER_THING).collect();
    assert!(same.len() * 20 > pairs.len() * 19);
    same.iter().sum::<f64>() / same.len() as f64
}

#[test]
fn pictures_converge_at_second_order() {
    let mut scene = scenes::read("matte", scenes::MATTE).unwrap();
    (scene.film.width, scene.film.height) = (128, 128);
    scene.film.integrator = Integrator::Whitted;
    let picture = |options: &EngineOptions| {
        let mut own = scene.clone();
        own.set_engine(options);
        render(&own, &Settings::default(), &()).unwrap()
    };
    let exact = picture(&EngineOptions::default());
    let errors = [500, 1000, 2000, 4000].map(|samples| {
        let method = Method::Hy;
        difference(&exact, &picture(&EngineOptions { method, samples, ..EngineOptions::default() }))
    });
    let slope = (errors[0] / errors[3]).log2() / 3.0;
    println!("{errors:?}, slope {slope}");
    assert!((1.7..2.3).contains(&slope), "{slope}, {errors:?}");
}
