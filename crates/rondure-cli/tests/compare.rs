//! `rondure compare`: figures, the picture of differences, limits and exit codes.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use std::fmt::Write;

use common::Desk;

/// An 8-bit PNG of one colour, with a square of another in it.
fn picture(width: u32, height: u32, square: [u8; 3]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let inside = |x: u32, y: u32| (4..12).contains(&x) && (4..12).contains(&y);
    let pixel = |i: u32| if inside(i % width, i / width) { square } else { [90, 120, 60] };
    let data: Vec<u8> = (0..width * height).flat_map(pixel).collect();
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    file
}

fn desk() -> Desk {
    let desk = Desk::new();
    desk.file("a.png", picture(20, 16, [90, 120, 60]));
    desk.file("b.png", picture(20, 16, [200, 120, 60]));
    desk.file("c.png", picture(16, 20, [200, 120, 60]));
    desk
}

#[test]
fn figures() {
    let desk = desk();
    let outcome = desk.run("compare b.png a.png");
    assert_eq!(outcome.code, 0, "{}", outcome.stderr);
    let figures = "\
pixels   64 of 320 are not the same
largest  0.475339
MSE      1.506313e-2
relMSE   7.364618e-1
PSNR     19.06 dB
FLIP     0.268075
";
    assert_eq!(outcome.stdout, figures);
    let outcome = desk.run("compare b.png a.png --json");
    for part in ["\"different_pixels\": 64.0,", "\"relmse\": 0.73646", "\"flip\": 0.26807"] {
        assert!(outcome.stdout.contains(part), "{}", outcome.stdout);
    }
    let same = desk.run("compare a.png a.png --exact --max-flip 0 --max-relmse 0");
    assert_eq!(same.code, 0);
    assert!(same.stdout.contains("pixels   0 of 320") && same.stdout.contains("infinite"));
}

#[test]
fn the_difference_is_black_where_there_is_none() {
    let desk = desk();
    assert_eq!(desk.run("compare b.png a.png -o d.png").code, 0);
    let file = std::io::BufReader::new(std::fs::File::open(desk.path("d.png")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut data = vec![0; 20 * 16 * 3];
    reader.next_frame(&mut data).unwrap();
    let at = |x: usize, y: usize| data[(y * 20 + x) * 3];
    assert!(at(19, 15) < 60 && at(8, 8) > 150, "{} {}", at(19, 15), at(8, 8));
}

#[test]
fn limits_decide_the_exit_code() {
    let desk = desk();
    for (limits, code) in [
        ("--max-flip 0.5", 0),
        ("--max-flip 0.01", 3),
        ("--max-relmse 100", 0),
        ("--max-relmse 1e-3", 3),
        ("--exact", 3),
        ("--max-flip 0.5 --exact", 3),
    ] {
        let outcome = desk.run(&format!("compare b.png a.png {limits}"));
        assert_eq!(outcome.code, code, "{limits}");
        assert!(outcome.stdout.contains("FLIP"));
    }
}

#[test]
fn bad_input() {
    let desk = desk();
    let whole = picture(20, 16, [1, 2, 3]);
    desk.file("cut.png", &whole[..whole.len() / 2])
        .file("text.png", "no picture")
        .file("a.jpg", "");
    desk.file("folder.png/file", "");
    let mut gallery = String::new();
    for (arguments, code) in [
        ("compare a.png c.png", 1),
        ("compare none.png a.png", 1),
        ("compare a.png cut.png", 1),
        ("compare text.png a.png", 1),
        ("compare folder.png a.png", 1),
        ("compare a.jpg a.png", 1),
        ("compare a.png b.png -o d.jpg", 1),
        ("compare a.png b.png -o no/d.png", 1),
        ("compare a.png", 2),
        ("compare a.png b.png --max-flip -1", 2),
        ("compare a.png b.png --pixels-per-degree 0", 2),
    ] {
        let outcome = desk.run(arguments);
        assert_eq!(outcome.code, code, "{arguments}: {}", outcome.stderr);
        writeln!(gallery, "$ rondure {arguments}\n{}\n", outcome.stderr.trim_end()).unwrap();
    }
    insta::assert_snapshot!(gallery);
}
