//! Work that is shared out, stopped, killed and gone on with: whatever happens, the picture has the same bits.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use std::{
    fs,
    io::{BufRead, BufReader, Read},
    path::Path,
    process::{Child, Command},
    thread,
    time::{Duration, Instant},
};

use common::Desk;
use rondure_film::{Room, Share};

/// A drum under a lamp, with a soft shadow.
const SCENE: &str = r#"
[film]
size = [48, 32]
spp = 6

[camera]
eye = [6, 0, 3]
look_at = [0, 0, 1]

[sky]
zenith = "lightsteelblue"
horizon = "white"

[[light]]
type = "sphere"
position = [3, 3, 5]
radius = 0.5
intensity = 40

[[object]]
profile = { file = "drum.path" }
material = { type = "glossy", color = "firebrick", roughness = 0.3 }

[[object]]
type = "plane"
material = { color = "gray" }
"#;

/// A ball beside the drum, with a caustic.
const GLASS: &str = r#"
[[object]]
type = "sphere"
position = [1.5, 1, 0.5]
radius = 0.5
material = { type = "glass" }
"#;

const DRUM: &str = "M 0 0 L 1 0 C 0.5 0.5 1.2 1.5 1 2 L 0 2 Z";

fn desk() -> Desk {
    let desk = Desk::new();
    desk.file("drum.toml", SCENE).file("drum.path", DRUM);
    desk
}

/// Runs a command that is to go well.
fn run(desk: &Desk, arguments: &str) -> String {
    let outcome = desk.run(arguments);
    assert_eq!(outcome.code, 0, "{arguments}: {}", outcome.stderr);
    outcome.stderr
}

/// Runs a command that is to fail, and looks for all of these words in what it says.
fn fails(desk: &Desk, arguments: &str, words: &[&str]) {
    let outcome = desk.run(arguments);
    assert_eq!(outcome.code, 1, "{arguments}: {}", outcome.stderr);
    for word in words {
        assert!(outcome.stderr.contains(word), "{arguments}: {}", outcome.stderr);
    }
}

fn same(desk: &Desk, a: &str, b: &str) {
    let read = |name: &str| fs::read(desk.path(name)).unwrap();
    assert!(read(a) == read(b), "{a} and {b} differ");
}

fn names(desk: &Desk) -> Vec<String> {
    let entries = fs::read_dir(desk.path(".")).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn parts_in_any_order_make_the_picture() {
    let desk = desk();
    run(&desk, "render drum.toml -q -o whole.exr");
    run(&desk, "render drum.toml -q -o whole.png --threads 1");
    for k in 1..=7 {
        run(&desk, &format!("render drum.toml -q --part {k}/7 -o part-{k}.rdf"));
    }
    let parts = |order: [u32; 7]| order.map(|k| format!("part-{k}.rdf")).join(" ");
    for order in [[1, 2, 3, 4, 5, 6, 7], [7, 3, 1, 6, 4, 2, 5], [4, 6, 7, 1, 2, 5, 3]] {
        run(&desk, &format!("merge {} -o merged.exr", parts(order)));
        same(&desk, "whole.exr", "merged.exr");
    }
    run(&desk, &format!("merge {} -o merged.png", parts([2, 1, 4, 3, 6, 5, 7])));
    same(&desk, "whole.png", "merged.png");
    run(&desk, "merge part-2.rdf part-5.rdf part-1.rdf -o some.rdf");
    run(&desk, "merge part-7.rdf part-6.rdf some.rdf part-3.rdf part-4.rdf -o merged.exr");
    same(&desk, "whole.exr", "merged.exr");
    // By tiles and samples, one of them found under its usual name.
    run(&desk, "render drum.toml -q --tile 0,0,48,20 --sample-range 0..5 -o a.rdf");
    run(&desk, "render drum.toml -q --tile 0,0,48,20 --sample-range 5..6 -o b.rdf");
    run(&desk, "render drum.toml -q --tile 0,20,48,12");
    run(&desk, "merge b.rdf drum.part.rdf a.rdf -o merged.exr");
    same(&desk, "whole.exr", "merged.exr");
}

#[test]
fn pictures_without_memory_are_the_same() {
    let desk = desk();
    for size in ["47x33", "16x16", "1x10000"] {
        let drum = format!("render drum.toml -q --size {size} --spp 1");
        let noisy = format!("render drum.toml -q --size {size} --spp 40 --noise 0.1");
        for name in ["a.exr", "a.png", "a.rdf"] {
            run(&desk, &format!("{drum} -o {name}"));
            run(&desk, &format!("{drum} -o b-{name} --memory 0"));
            same(&desk, name, &format!("b-{name}"));
        }
        run(&desk, "merge a.rdf -o c.png --memory 0");
        same(&desk, "a.png", "c.png");
        // From one place to the other.
        run(&desk, &format!("{drum} -o c.exr --checkpoint c.rdf --time 0 --memory 0"));
        run(&desk, &format!("{drum} -o c.exr --checkpoint c.rdf --resume"));
        same(&desk, "a.exr", "c.exr");
        run(&desk, &format!("{drum} -o c.exr --checkpoint c.rdf --time 0"));
        run(&desk, &format!("{drum} -o c.exr --checkpoint c.rdf --resume --memory 0"));
        same(&desk, "a.exr", "c.exr");
        if size != "1x10000" {
            run(&desk, &format!("{noisy} -o a.exr"));
            run(&desk, &format!("{noisy} -o b.exr --memory 0 --preview p.png --scratch ."));
            same(&desk, "a.exr", "b.exr");
        }
    }
    let left = names(&desk);
    assert!(left.iter().all(|name| !name.starts_with('.')), "{left:?}");
    fails(
        &desk,
        "render drum.toml -q -o x.exr --memory 0 --scratch none",
        &["cannot keep the sums of the picture in `none`", "--scratch"],
    );
}

#[test]
fn parts_that_do_not_fit_are_told_by_name() {
    let desk = desk();
    for k in 1..=3 {
        run(&desk, &format!("render drum.toml -q --part {k}/3 -o {k}.rdf"));
    }
    run(&desk, "render drum.toml -q --part 3/3 -o seed.rdf --seed 1");
    run(&desk, "render drum.toml -q --part 3/3 -o spp.rdf --spp 5");
    run(&desk, "render drum.toml -q --part 3/3 -o size.rdf --size 48x33");
    run(&desk, "render drum.toml -q --tile 3,10,1,5 -o tile.rdf");
    desk.file("drum.path", "M 0 0 L 1 0 L 1 2 L 0 2 Z");
    run(&desk, "render drum.toml -q --part 3/3 -o profile.rdf");
    fails(&desk, "merge 1.rdf 3.rdf -o x.png", &["missing: part 2/3"]);
    fails(&desk, "merge 1.rdf 2.rdf 1.rdf 3.rdf -o x.png", &["`1.rdf` and `1.rdf` have 48x10"]);
    fails(
        &desk,
        "merge 1.rdf 2.rdf tile.rdf -o x.png",
        &["`tile.rdf` and `2.rdf` have", "1x5 at 3,10"],
    );
    fails(
        &desk,
        "merge 1.rdf 2.rdf seed.rdf -o x.png",
        &["`seed.rdf` does not", "seed is 1, not 0"],
    );
    fails(&desk, "merge 1.rdf 2.rdf spp.rdf -o x.png", &["`spp.rdf`", "for 5 samples"]);
    fails(&desk, "merge 1.rdf 2.rdf size.rdf -o x.png", &["`size.rdf`", "48x33 pixels, not 48x32"]);
    fails(&desk, "merge 1.rdf 2.rdf profile.rdf -o x.png", &["`profile.rdf`", "another scene"]);
    fails(&desk, "merge tile.rdf -o x.png", &["missing: 48x10 at 0,0, samples 0..6; 3x5 at 0,10"]);
    fails(&desk, "merge 1.rdf none.rdf -o x.png", &["cannot read `none.rdf`"]);
    fails(&desk, "merge 1.rdf drum.toml -o x.png", &["`drum.toml` is not a part"]);
    fails(&desk, "merge 1.rdf -o x.jpg", &["PNG or OpenEXR"]);
    let good = fs::read(desk.path("2.rdf")).unwrap();
    let damage = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 4;
        desk.file("2.rdf", bytes);
    };
    damage(40);
    fails(&desk, "merge 1.rdf 2.rdf 3.rdf -o x.png", &["`2.rdf` is damaged", "header"]);
    damage(good.len() / 2);
    fails(&desk, "merge 1.rdf 2.rdf 3.rdf -o x.png", &["`2.rdf` is damaged", "sums"]);
    desk.file("2.rdf", &good[..good.len() / 2]);
    fails(&desk, "merge 1.rdf 2.rdf 3.rdf -o x.png", &["`2.rdf` is cut off"]);
    assert!(!desk.path("x.png").exists());
    desk.file("2.rdf", &good);
    fs::rename(desk.path("profile.rdf"), desk.path("old.rdf")).unwrap();
    run(&desk, "merge 1.rdf 2.rdf 3.rdf -o x.png");
}

#[test]
fn parts_with_a_limit_of_noise_make_the_picture() {
    let desk = desk();
    let drum = "render drum.toml -q --size 40x54 --spp 40 --noise 0.1";
    run(&desk, &format!("{drum} -o whole.exr --threads 1"));
    for k in 1..=7 {
        run(&desk, &format!("{drum} --part {k}/7 -o part-{k}.rdf --threads 2"));
    }
    for order in [[1, 2, 3, 4, 5, 6, 7], [7, 3, 1, 6, 4, 2, 5], [4, 6, 7, 1, 2, 5, 3]] {
        let parts = order.map(|k| format!("part-{k}.rdf")).join(" ");
        run(&desk, &format!("merge {parts} -o merged.exr"));
        same(&desk, "whole.exr", "merged.exr");
    }
    run(&desk, &format!("{drum} --tile 0,0,24,54 -o left.rdf"));
    run(&desk, &format!("{drum} --tile 24,0,16,54 -o right.rdf"));
    run(&desk, "merge right.rdf left.rdf -o merged.exr");
    same(&desk, "whole.exr", "merged.exr");
    fails(&desk, &format!("{drum} --part 1/8 -o x.rdf"), &["54 rows", "8 parts", "8 rows"]);
    let cut = ["whole blocks of 8x8 pixels", "leave away --noise"];
    fails(&desk, &format!("{drum} --tile 0,0,23,54 -o x.rdf"), &cut);
    fails(&desk, &format!("{drum} --sample-range 0..20 -o x.rdf"), &cut);
}

#[test]
fn files_of_two_kinds_with_one_name_are_refused() {
    let desk = desk();
    desk.file("c.rdf", "old");
    for (options, words) in [
        ("-o c.rdf --checkpoint ./c.rdf", ["`c.rdf`", "the picture and the checkpoint"]),
        ("-o x.png --checkpoint x.png", ["`x.png`", "the picture and the checkpoint"]),
        (
            "-o x.png --checkpoint c.png --preview c.png",
            ["`c.png`", "the preview and the checkpoint"],
        ),
    ] {
        fails(&desk, &format!("render drum.toml {options} --resume"), &words);
    }
    assert_eq!(names(&desk), ["c.rdf", "drum.path", "drum.toml"]);
    assert_eq!(fs::read_to_string(desk.path("c.rdf")).unwrap(), "old");
}

#[test]
fn options_for_parts_are_checked() {
    let desk = desk();
    fails(&desk, "render drum.toml --part 1/2 -o x.png", &["a part of a picture", ".rdf"]);
    fails(&desk, "render drum.toml --part 1/40 -o x.rdf", &["32 rows", "40 parts"]);
    fails(&desk, "render drum.toml --tile 40,0,9,1 -o x.rdf", &["not within the picture of 48x32"]);
    fails(&desk, "render drum.toml --preview x.exr", &["previews are PNG files"]);
    fails(&desk, "render drum.toml --sample-range 4..7 -o x.rdf", &["samples 0..6 only"]);
    for wrong in
        ["--part 0/2", "--part 2", "--tile 1,2,3", "--sample-range 5..5", "--resume", "--time 5x"]
    {
        assert_eq!(desk.run(&format!("render drum.toml {wrong}")).code, 2, "{wrong}");
    }
    assert_eq!(names(&desk), ["drum.path", "drum.toml"]);
}

#[cfg(unix)]
fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([name, &id]).status().unwrap().success());
}

fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < Duration::from_secs(20), "{} does not come", path.display());
        thread::sleep(Duration::from_millis(5));
    }
}

/// Kills work 20 times at random moments, each time while it runs, and lets it end then.
#[cfg(unix)]
fn kill_and_go_on(options: &str) {
    use std::os::unix::process::ExitStatusExt;
    let desk = desk();
    desk.file("drum.toml", SCENE.to_owned() + GLASS);
    let start = Instant::now();
    run(&desk, &format!("render drum.toml -q -o whole.exr {options}"));
    let all = start.elapsed().as_millis() as u64;
    let arguments = format!(
        "render drum.toml -q -o killed.exr {options} --checkpoint c.rdf --resume --every 0s"
    );
    let (mut killed, mut gone_on, mut ended) = (0, 0, 0);
    let mut random = 12345_u64;
    while killed < 20 {
        random =
            random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        gone_on += u32::from(desk.path("c.rdf").exists());
        let mut child = desk.command(&arguments).spawn().unwrap();
        thread::sleep(Duration::from_millis((random >> 33) % (all / 3 + 1)));
        signal(&child, "-KILL");
        let status = child.wait().unwrap();
        if status.signal() == Some(9) {
            killed += 1;
        } else {
            // It came to its end before; the next one begins anew.
            assert!(status.success());
            same(&desk, "whole.exr", "killed.exr");
            ended += 1;
        }
        assert!(ended < 100);
    }
    assert!(gone_on > 5, "{gone_on}");
    run(&desk, &arguments);
    same(&desk, "whole.exr", "killed.exr");
    // Nothing is left of checkpoints by those who were killed while they wrote; of other files there may be temporary ones.
    let left = names(&desk);
    let left: Vec<_> = left.iter().filter(|name| !name.starts_with(".rondure-")).collect();
    assert_eq!(left, ["drum.path", "drum.toml", "killed.exr", "whole.exr"]);
}

#[cfg(unix)]
#[test]
fn killed_work_goes_on_to_the_same_picture() {
    kill_and_go_on("--size 64x48 --spp 10");
}

#[cfg(unix)]
#[test]
fn killed_work_with_a_limit_of_noise_goes_on_to_the_same_picture() {
    kill_and_go_on("--size 64x48 --spp 32 --noise 0.1");
}

#[cfg(unix)]
#[test]
fn killed_work_without_memory_goes_on_to_the_same_picture() {
    kill_and_go_on("--size 64x48 --spp 10 --memory 0");
}

#[test]
fn time_stops_the_work_and_checkpoints_go_on_with_it() {
    let desk = desk();
    run(&desk, "render drum.toml -q -o whole.png");
    let said = run(&desk, "render drum.toml -o part.png --time 0 --checkpoint c.rdf");
    assert!(said.contains("stopped at 0 %; written: the checkpoint c.rdf"), "{said}");
    assert_eq!(names(&desk), ["c.rdf", "drum.path", "drum.toml", "whole.png"]);
    fails(&desk, "render drum.toml -o x.png --checkpoint c.rdf", &["a checkpoint `c.rdf` already"]);
    run(&desk, "render drum.toml -q -o part.png --checkpoint c.rdf --resume");
    same(&desk, "whole.png", "part.png");
    assert!(!desk.path("c.rdf").exists());
    // Nothing to go on from is no error.
    run(&desk, "render drum.toml -q -o part.png --checkpoint c.rdf --resume");
    same(&desk, "whole.png", "part.png");
}

#[test]
fn foreign_and_damaged_checkpoints_are_refused() {
    let desk = desk();
    run(&desk, "render drum.toml -q -o x.png --time 0 --checkpoint c.rdf");
    let refused = |options: &str, words: &[&str]| {
        let arguments =
            format!("render drum.toml -q -o x.png --checkpoint c.rdf --resume {options}");
        fails(&desk, &arguments, &[&["cannot go on from the checkpoint `c.rdf`"], words].concat());
    };
    refused("--size 48x33", &["48x32 pixels, not 48x33"]);
    refused("--spp 7", &["for 6 samples"]);
    refused("--seed 3", &["seed is 0, not 3"]);
    refused("--engine exact", &["engine is wide, not exact"]);
    fails(&desk, "render drum.toml -q -o x.exr --checkpoint c.rdf --resume", &["other layers"]);
    fails(
        &desk,
        "render drum.toml -q -o x.rdf --tile 0,0,5,5 --checkpoint c.rdf --resume",
        &["another part of the picture"],
    );
    let good = fs::read(desk.path("c.rdf")).unwrap();
    let mut other = Share::read(desk.path("c.rdf"), &Room::default()).unwrap();
    let version = other.recipe.settings.iter_mut().find(|(key, _)| key == "version").unwrap();
    version.1 = "0.0.9".to_owned();
    other.as_ref().write(desk.path("c.rdf")).unwrap();
    refused("", &["version is 0.0.9, not"]);
    desk.file("c.rdf", &good);
    desk.file("drum.path", "M 0 0 L 1 0 L 1 2 L 0 2 Z");
    refused("", &["another scene, or the scene has been changed"]);
    desk.file("drum.path", DRUM);
    desk.file("c.rdf", &good[..good.len() / 2]);
    refused("", &["cut off"]);
    for at in [3, 9, 60, good.len() / 2, good.len() - 1] {
        let mut bytes = good.clone();
        bytes[at] ^= 16;
        desk.file("c.rdf", &bytes);
        refused("", &["`c.rdf`"]);
        assert_eq!(fs::read(desk.path("c.rdf")).unwrap(), bytes);
    }
    desk.file("c.rdf", &good);
    run(&desk, "render drum.toml -q -o x.png --checkpoint c.rdf --resume");
    assert_eq!(names(&desk), ["drum.path", "drum.toml", "x.png"]);
}

#[cfg(unix)]
#[test]
fn two_processes_on_one_checkpoint_are_told() {
    let desk = desk();
    let arguments =
        "render drum.toml -q -o x.png --size 200x200 --spp 100000 --checkpoint c.rdf --resume";
    let mut first = desk.command(arguments).spawn().unwrap();
    wait_for(&desk.path("c.rdf"));
    let who = format!("process {} is working on the checkpoint `c.rdf`", first.id());
    fails(&desk, arguments, &[&who]);
    signal(&first, "-KILL");
    first.wait().unwrap();
    let outcome = desk.run(&format!("{arguments} --time 0"));
    assert_eq!((outcome.code, &*outcome.stderr), (0, ""));
}

#[cfg(unix)]
#[test]
fn interrupted_work_writes_what_there_is() {
    let desk = desk();
    desk.file("out.png", "old");
    // A preview shows that the first pass is through.
    let arguments =
        "render drum.toml -o out.png --spp 1000000 --preview so-far.png --checkpoint c.rdf";
    let mut child = desk.command(arguments).spawn().unwrap();
    wait_for(&desk.path("so-far.png"));
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let mut text = String::new();
    child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    assert!(text.contains("written: the checkpoint c.rdf; out.png, unfinished"), "{text}");
    for name in ["out.png", "so-far.png"] {
        let bytes = fs::read(desk.path(name)).unwrap();
        assert!(png::Decoder::new(std::io::Cursor::new(bytes)).read_info().is_ok(), "{name}");
    }
    assert_eq!(names(&desk), ["c.rdf", "drum.path", "drum.toml", "out.png", "so-far.png"]);
}

#[cfg(unix)]
#[test]
fn a_picture_with_holes_is_not_written() {
    let desk = desk();
    let quick = SCENE.replace("[film]", "[film]\nintegrator = \"whitted\"");
    desk.file("drum.toml", quick).file("out.png", "old");
    // The first pass takes much longer than the first line of progress.
    let arguments = "render drum.toml -o out.png --size 1500x1500 --spp 16 --threads 1 --engine kj";
    let mut child = desk.command(arguments).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    said.read_line(&mut String::new()).unwrap();
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let mut text = String::new();
    said.read_to_string(&mut text).unwrap();
    assert!(text.contains("stopped; nothing has been written"), "{text}");
    assert_eq!(fs::read_to_string(desk.path("out.png")).unwrap(), "old");
    assert_eq!(names(&desk), ["drum.path", "drum.toml", "out.png"]);
}

/// A limit on the size of files stands for a disk that is full.
#[cfg(unix)]
#[test]
fn a_full_disk_is_found_before_the_work() {
    let desk = desk();
    let binary = env!("CARGO_BIN_EXE_rondure");
    // The work would take hours.
    for (options, place, option) in [
        ("-o out.exr --size 300x300", "out.exr", "with -o"),
        ("-o small.png --size 40x30 --checkpoint c.rdf", "c.rdf", "with --checkpoint"),
        ("-o out.png --size 300x300", "out.png", "with -o"),
    ] {
        let line = format!(
            "trap '' XFSZ; ulimit -f 16; exec {binary} render drum.toml {options} --spp 1000000"
        );
        let output =
            Command::new("sh").args(["-c", &line]).current_dir(desk.path(".")).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("cannot write `") && said.contains(option), "{place}: {said}");
    }
    assert_eq!(names(&desk), ["drum.path", "drum.toml"]);
}

/// The disk fills up during the work: what was computed goes elsewhere.
#[cfg(unix)]
#[test]
fn work_is_not_lost_if_the_picture_cannot_be_written_in_the_end() {
    let desk = desk();
    run(&desk, "render drum.toml -q -o whole.png --spp 200");
    fs::create_dir(desk.path("folder")).unwrap();
    let mut child = desk
        .command("render drum.toml -o folder/out.png --spp 200 --preview folder/p.png")
        .spawn()
        .unwrap();
    wait_for(&desk.path("folder/p.png"));
    fs::remove_dir_all(desk.path("folder")).unwrap();
    let mut text = String::new();
    child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{text}");
    assert!(text.contains("nothing is lost: `rondure merge ./out.rescued-"), "{text}");
    let rescued = names(&desk).into_iter().find(|name| name.contains("rescued")).unwrap();
    run(&desk, &format!("merge {rescued} -o out.png"));
    same(&desk, "whole.png", "out.png");
}
