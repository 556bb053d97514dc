//! All kinds of bad input: each gives a clear error and a non-zero exit code, and never a panic.
//!
//! The snapshots are meant to be read: a gallery of everything that can be said.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use std::fmt::Write;

use common::{CONE, Desk};

const HEADER: &str = "ox,oy,oz,dx,dy,dz\n";

/// Runs the command, checks that it fails in an orderly way, and adds what it says to the gallery.
fn show(gallery: &mut String, desk: &Desk, title: &str, arguments: &str, code: i32) {
    let outcome = desk.run(arguments);
    let said = &outcome.stderr;
    assert_eq!(outcome.code, code, "{title}: {said}");
    assert!(!said.contains("panicked") && !said.trim().is_empty(), "{title}: {said}");
    writeln!(gallery, "## {title}\n$ rondure {arguments}\n{}\n", said.trim_end()).unwrap();
}

/// Rays that are wrong: a name, and the text of the file.
#[test]
fn rays() {
    let desk = Desk::new();
    desk.file("cone.path", CONE);
    let mut gallery = String::new();
    let mut case = |title: &str, text: &[u8]| {
        desk.file("rays.csv", text);
        show(&mut gallery, &desk, title, "trace cone.path --rays rays.csv", 1);
    };
    let row = |row: &str| [HEADER.as_bytes(), b"5,0,1,-1,0,0\n", row.as_bytes(), b"\n"].concat();
    let ranged = |row: &str| [b"ox,oy,oz,dx,dy,dz,tmin,tmax\n", row.as_bytes(), b"\n"].concat();

    case("empty file", b"");
    case("no header", b"0,0,0,1,0,0\n");
    case("empty first line", b"\nox,oy,oz,dx,dy,dz\n");
    case("missing columns", b"ox,oy,oz,dx\n1,2,3,4\n");
    case("misspelled column", b"ox,oy,oz,dx,dy,DZ\n");
    case("unknown column", b"ox,oy,oz,dx,dy,dz,weight\n");
    case("column named twice", b"ox,oy,oz,dx,dy,dz,ox\n");
    case("semicolons", b"ox;oy;oz;dx;dy;dz\n0;0;0;1;0;0\n");
    case("header not UTF-8", b"ox,oy,oz,dx,dy,d\xe4\n");
    case("UTF-16", b"\xff\xfeo\0x\0,\0o\0y\0\n\0");
    case("binary file", b"\x7fELF\x02\x01\x01\0\0\0\n\0");
    case("missing values", &row("1,2,3"));
    case("short direction", &row("1,2,3,1e-320,0,0"));
    case("too many values", &row("1,2,3,4,5,6,7"));
    case("empty value", &row("1,2,,4,5,6"));
    case("not a number", &row("1,2,three,4,5,6"));
    case("decimal point twice", &row("1,2,3,4.5.6,5,6"));
    case("hexadecimal", &row("1,2,3,0x10,5,6"));
    case("value not UTF-8", &[HEADER.as_bytes(), b"1,2,3,4,5,\xe9\n"].concat());
    case("NaN", &row("1,2,3,4,NaN,6"));
    case("infinite origin", &row("inf,2,3,4,5,6"));
    case("infinite direction", &row("1,2,3,4,5,-inf"));
    case("number too large", &row("1,2,3,1e999,5,6"));
    case("zero direction", &row("1,2,3,0,0,-0"));
    case("range the wrong way round", &ranged("1,2,3,4,5,6,1,0.5"));
    case("NaN as a range", &ranged("1,2,3,4,5,6,0,nan"));
    case("number too large for a range", &ranged("1,2,3,4,5,6,0,1e400"));
    case("row in a long line", &row(&format!("1,2,3,4,5,{}", "x".repeat(5000))));
    case("line too long", &vec![b'1'; (1 << 20) + 1000]);
    case("comment", &row("# that was all"));
    insta::assert_snapshot!(gallery);
}

#[test]
fn files_of_trace() {
    let desk = Desk::new();
    desk.file("cone.path", CONE).file("rays.csv", HEADER).file("folder/file", "");
    let mut gallery = String::new();
    let mut case = |title: &str, arguments: &str, code| {
        show(&mut gallery, &desk, title, arguments, code);
    };
    case("missing profile", "trace none.path --rays rays.csv", 1);
    case("missing rays", "trace cone.path --rays none.csv", 1);
    case("folder as profile", "trace folder --rays rays.csv", 1);
    case("folder as rays", "trace cone.path --rays folder", 1);
    case("no rays", "trace cone.path", 2);
    case("no profile", "trace --rays rays.csv", 2);
    case("no threads", "trace cone.path --rays rays.csv --threads 0", 2);
    case("unknown option", "trace cone.path --rays rays.csv --al", 2);
    case("two answers", "trace cone.path --rays rays.csv --all --spans", 2);
    case("fill rule without spans", "trace cone.path --rays rays.csv --fill-rule evenodd", 2);
    desk.file("line.path", "M 1 0 L 1 2");
    case("spans of an open profile", "trace line.path --rays rays.csv --spans", 1);
    case("too thick", "trace line.path --rays rays.csv --thickness 1.5", 1);
    case("thickness not positive", "trace line.path --rays rays.csv --thickness -1", 1);
    case("rim without a wall", "trace line.path --rays rays.csv --rim round", 2);
    insta::assert_snapshot!(gallery);
}

#[test]
fn profiles() {
    let desk = Desk::new();
    desk.file("rays.csv", HEADER);
    let mut gallery = String::new();
    let mut case = |title: &str, name: &str, options: &str, text: &[u8]| {
        desk.file(name, text);
        let arguments = format!("trace {name} --rays rays.csv {options}");
        show(&mut gallery, &desk, title, arguments.trim_end(), 1);
    };
    let svg = |inside: &str| {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 9 9\">\n{inside}\n</svg>\n"
        )
        .into_bytes()
    };
    let shapes = "<path id=\"a\" d=\"M 1 1 L 2 2\"/>\n<path id=\"b\" d=\"M 1 1 L 2 3\"/>";

    case("path: empty", "it.path", "", b"");
    case("path: a point alone", "it.path", "", b"M 1 2");
    case("path: no extent", "it.path", "", b"M 1 2 L 1 2");
    case("path: does not begin with M", "it.path", "", b"L 1 2");
    case("path: unknown command", "it.path", "", b"M 0 0\nL 1 0\nX 1 2");
    case("path: a coordinate is missing", "it.path", "", b"M 0 0 L 1");
    case("path: not a number", "it.path", "", b"M 0 0 L 1 one");
    case("path: NaN", "it.path", "", b"M 0 0 L NaN 1");
    case("path: number too large", "it.path", "", b"M 0 0 L 1e999 1");
    case("path: larger than can be squared", "it.path", "", b"M 0 0 L 1e120 1");
    case("path: flag of an arc", "it.path", "", b"M 0 0 A 1 1 0 2 1 1 1");
    case("path: point beyond the axis", "it.path", "", b"M 0 0\nL 1 0 L -0.5 1");
    case("path: curve beyond the axis", "it.path", "", b"M 1 0 C -2 0 -2 1 1 1");
    case("path: not UTF-8", "it.path", "", b"M 0 0 \xff");
    case("path: binary", "it.path", "", b"\x7fELF\x02\x01\x01\0\0");
    case("path: option for drawings", "it.path", "--axis 3", b"M 0 0 L 1 1");
    case("path: negative scale", "it.path", "--scale -1", b"M 0 0 L 1 1");
    case("svg: not XML", "it.svg", "", b"M 0 0 L 1 1");
    case("svg: cut short", "it.svg", "", b"<svg xmlns=\"http://www.w3.org/2000/svg\"><path d=\"M");
    case("svg: not SVG", "it.svg", "", b"<html></html>");
    case("svg: no shape", "it.svg", "", &svg(""));
    case("svg: several shapes", "it.svg", "", &svg(shapes));
    case("svg: no such shape", "it.svg", "--svg-id c", &svg(shapes));
    case("svg: path data wrong", "it.svg", "", &svg("<path d=\"M 1 1 L 2\"/>"));
    case("svg: across the axis", "it.svg", "--axis 1.5", &svg("<path d=\"M 1 1 L 2 2\"/>"));
    case("svg: axis not finite", "it.svg", "--axis nan", &svg("<path d=\"M 1 1 L 2 2\"/>"));
    case("csv: not a number", "it.csv", "", b"r,z\n0,0\n1,zwei\n2,2\n");
    case("csv: one point", "it.csv", "", b"0,0\n");
    case("csv: three columns", "it.csv", "", b"0,0,0\n1,1,1\n");
    case("csv: beyond the axis", "it.csv", "--spline natural", b"0,0\n1,0\n-1,1\n");
    case(
        "csv: spline beyond the axis",
        "it.csv",
        "--spline natural",
        b"0,0\n9,1\n0,2\n0.1,3\n9,4\n",
    );
    case("unknown kind of file", "it.obj", "", b"v 0 0 0\n");
    case("no kind of file", "it", "", b"M 0 0 L 1 1");
    insta::assert_snapshot!(gallery);
}

#[test]
#[cfg(unix)]
fn files_that_never_end() {
    let desk = Desk::new();
    desk.file("cone.path", CONE).file("rays.csv", HEADER);
    std::os::unix::fs::symlink("/dev/zero", desk.path("endless.path")).unwrap();
    let mut gallery = String::new();
    let mut case = |title: &str, arguments: &str| show(&mut gallery, &desk, title, arguments, 1);
    case("endless profile", "trace endless.path --rays rays.csv");
    case("endless rays", "trace cone.path --rays endless.path");
    insta::assert_snapshot!(gallery);
}

#[test]
fn scenes() {
    const CAMERA: &str =
        "[camera]\neye = [6, 0, 3]\nlook_at = [0, 0, 1]\n[sky]\ncolor = \"white\"\n";
    let desk = Desk::new();
    desk.file("folder.toml/file", "");
    let mut gallery = String::new();
    let mut case = |title: &str, text: &[u8]| {
        desk.file("scene.toml", text);
        show(&mut gallery, &desk, title, "check scene.toml", 1);
    };
    let scene = |rest: &str| [CAMERA, rest].concat().into_bytes();

    case("empty", b"");
    case("not TOML", b"this is a scene");
    case("a string that does not end", &scene("[materials.clay]\ntype = \"matte\n"));
    case("key twice", b"[camera]\neye = [6, 0, 3]\neye = [6, 0, 3]\n");
    case("not UTF-8", b"# caf\xe9\n");
    case("no camera", b"[film]\nspp = 3\n");
    case("camera without an eye", b"[camera]\nlook_at = [0, 0, 1]\n");
    case("unknown table", &scene("[fim]\nspp = 3\n"));
    case("unknown key", &scene("[film]\nsp = 3\n"));
    case("wrong type", &scene("[film]\nspp = \"many\"\n"));
    case("zero samples", &scene("[film]\nspp = 0\n"));
    case("a film without area", &scene("[film]\nsize = [0, 600]\n"));
    case("vector of two", b"[camera]\neye = [6, 0]\nlook_at = [0, 0, 1]\n");
    case("infinite number", b"[camera]\neye = [6, 0, inf]\nlook_at = [0, 0, 1]\n");
    case("unknown kind of light", &scene("[[light]]\ntype = \"torch\"\n"));
    case("unknown kind of material", &scene("[materials.a]\ntype = \"mat\"\ncolor = \"red\"\n"));
    case("unknown colour", &scene("[materials.a]\ntype = \"matte\"\ncolor = \"rad\"\n"));
    case(
        "colour with too few digits",
        &scene("[materials.a]\ntype = \"matte\"\ncolor = \"#12\"\n"),
    );
    case("unknown material", &scene("[[object]]\ntype = \"plane\"\nmaterial = \"clay\"\n"));
    case("unknown shape", &scene("[[object]]\ntype = \"sphere2\"\n"));
    case("unknown profile", &scene("[[object]]\nprofile = \"vase\"\n"));
    case("missing profile file", &scene("[[object]]\nprofile = { file = \"vase.path\" }\n"));
    case(
        "profile across the axis",
        &scene("[profiles.a]\npath = \"M 1 0\\nL -1 2\"\n[[object]]\nprofile = \"a\"\n"),
    );
    case("several things at once", b"[film]\nspp = -1\nbits = 12\n[camera]\neye = 3\nfv = 40\n");
    show(&mut gallery, &desk, "missing file", "check none.toml", 1);
    show(&mut gallery, &desk, "folder", "check folder.toml", 1);
    show(&mut gallery, &desk, "rendering a bad scene", "render scene.toml", 1);
    show(&mut gallery, &desk, "rendering no file", "render none.toml", 1);
    show(&mut gallery, &desk, "no scene", "render", 2);
    show(&mut gallery, &desk, "size without a height", "render scene.toml --size 800", 2);
    show(&mut gallery, &desk, "no samples", "render scene.toml --spp 0", 2);
    show(&mut gallery, &desk, "negative seed", "render scene.toml --seed=-1", 2);
    assert!(!desk.path("scene.png").exists());
    insta::assert_snapshot!(gallery);
}
