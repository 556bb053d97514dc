//! Renders one scene with Rondure and with POV-Ray, on one thread each, and compares the times.
//!
//! The scene is first brought down to what both programs can draw alike ([`level`]), then written
//! for both; the runs alternate, so that other load on the machine hits both.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

use clap::Parser;
use rondure_render::{Settings, Statistics};

use crate::{
    measure::{Run, Spread, run},
    picture::Picture,
};

mod lathe;
mod level;
mod measure;
mod picture;
mod pov;
mod povray;

/// Render one scene with Rondure and POV-Ray and compare the times
#[derive(Debug, Parser)]
struct Options {
    /// The scene file
    #[arg(default_value = "scenes/still-life.toml")]
    scene: PathBuf,

    /// Where the scenes and pictures of both programs go
    #[arg(short, long, default_value = "target/bench-povray")]
    output: PathBuf,

    /// How often each program renders each picture
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,

    /// Samples in each pixel, one table for each number: 1, or one more than a square, which is what
    /// POV-Ray can take
    #[arg(long, num_args = 1.., default_values_t = [1], value_parser = samples)]
    spp: Vec<u32>,

    /// The size of the pictures: width and height
    #[arg(long, num_args = 2, default_values_t = [800, 600])]
    size: Vec<u32>,
}

fn samples(text: &str) -> Result<u32, String> {
    let spp = text.parse().map_err(|_| "not a whole number")?;
    let possible: Vec<_> = [1].into_iter().chain((2..10).map(|grid| grid * grid + 1)).collect();
    if possible.contains(&spp) { Ok(spp) } else { Err(format!("must be one of {possible:?}")) }
}

/// The same scene for both.
struct Scenes {
    rondure: PathBuf,
    povray: PathBuf,
    scene: rondure_scene::Scene,
}

impl Scenes {
    fn size(&self) -> (u32, u32) {
        (self.scene.film.width, self.scene.film.height)
    }
}

fn main() -> ExitCode {
    match compare(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn compare(options: &Options) -> Result<(), Box<dyn Error>> {
    let version = povray::version()?;
    let rondure = std::env::current_exe()?.with_file_name("rondure");
    let mut scenes = write_scenes(options)?;
    println!("{version} and Rondure {}, one thread each", env!("CARGO_PKG_VERSION"));
    println!("{}, {}x{}", options.scene.display(), scenes.size().0, scenes.size().1);
    println!("scenes: {}, {}", scenes.povray.display(), scenes.rondure.display());
    for &spp in &options.spp {
        let at = |name: &str| options.output.join(format!("{name}-{spp}.png"));
        let pictures = [at("povray"), at("rondure")];
        let mut runs: Vec<[Run; 2]> = Vec::new();
        for _ in 0..options.runs {
            let mut pov = povray::command(&scenes.povray, &pictures[0], scenes.size(), spp);
            let mut own = rondure_command(&rondure, &scenes, &pictures[1], spp);
            runs.push([run(&mut pov)?, run(&mut own)?]);
        }
        scenes.scene.film.spp = spp;
        scenes.scene.film.integrator = rondure_scene::Integrator::Whitted;
        let counted = rondure_render::render(&scenes.scene, &Settings::default(), &())?;
        print_table(spp, &runs, counted.statistics());
        let [a, b] = [Picture::read(&pictures[0])?, Picture::read(&pictures[1])?];
        let difference = a.difference(&b).ok_or("the pictures differ in size")?;
        println!("  pictures: {}, {}", pictures[0].display(), pictures[1].display());
        println!("  mean difference of blocks of 8x8 pixels: {:.1} %", 100.0 * difference);
    }
    Ok(())
}

fn write_scenes(options: &Options) -> Result<Scenes, Box<dyn Error>> {
    let path = &options.scene;
    let shown = |report: rondure_scene::Report| report.plain();
    let (scene, _) = rondure_scene::read_scene(path).map_err(shown)?;
    let text = fs::read_to_string(path)?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let leveled = level::level(&text, folder, &scene)?;
    fs::create_dir_all(&options.output)?;
    let [rondure, povray] = ["scene.toml", "scene.pov"].map(|name| options.output.join(name));
    fs::write(&rondure, leveled)?;
    let (mut scene, _) = rondure_scene::read_scene(&rondure).map_err(shown)?;
    (scene.film.width, scene.film.height) = (options.size[0], options.size[1]);
    let (text, notes) = pov::write(&scene)?;
    fs::write(&povray, text)?;
    for note in notes {
        eprintln!("note: {note}");
    }
    Ok(Scenes { rondure, povray, scene })
}

fn rondure_command(program: &Path, scenes: &Scenes, picture: &Path, spp: u32) -> Command {
    let mut command = Command::new(program);
    command.arg("render").arg(&scenes.rondure).arg("-o").arg(picture);
    // What POV-Ray does, too.
    command.args(["--integrator", "whitted"]);
    let (width, height) = scenes.size();
    command.args(["--size".into(), format!("{width}x{height}")]);
    command.args(["--spp".into(), spp.to_string()]);
    command.args(["--threads", "1", "--quiet"]);
    command
}

fn print_table(spp: u32, runs: &[[Run; 2]], rays: &Statistics) {
    println!("\nsamples per pixel: {spp}; {} runs in turn: median (least to most)", runs.len());
    println!("  {:<24} {:>26} {:>26} {:>8}", "seconds", "POV-Ray", "Rondure", "ratio");
    let cell = |s: Spread| format!("{:.3} ({:.3} to {:.3})", s.median, s.least, s.greatest);
    let row = |name: &str, of: &dyn Fn(&Run) -> f64| {
        let [pov, own] = [0, 1].map(|i| Spread::of(runs.iter().map(|pair| of(&pair[i]))));
        let ratio = pov.median / own.median;
        println!("  {name:<24} {:>26} {:>26} {ratio:>8.2}", cell(pov), cell(own));
        ratio
    };
    let ratio = row("whole process, CPU", &|run| run.user);
    row("whole process, clock", &|run| run.wall);
    let traces: Option<Vec<_>> =
        runs.iter().map(|[pov, _]| povray::trace_seconds(&pov.said)).collect();
    if let Some(trace) = traces.map(Spread::of) {
        println!("  {:<24} {:>26}", "its tracing alone, CPU", cell(trace));
    }
    let Statistics { camera_rays, secondary_rays, shadow_rays, .. } = rays;
    let followed = camera_rays + secondary_rays;
    let Some([pov, _]) = runs.last() else { return };
    if let Some(pov_followed) = povray::rays(&pov.said) {
        let per_ray = ratio * followed as f64 / pov_followed;
        println!("  {:<24} {:>26} {:>26} {per_ray:>8.2}", "CPU, per ray followed", "", "");
    }
    println!("  POV-Ray: {}", povray::ray_counts(&pov.said).join("; "));
    println!("  Rondure: Rays: {followed}; Shadow Rays: {shadow_rays}");
}
