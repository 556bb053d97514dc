//! `rondure trace` as part of a pipeline: order, memory, partners that wait or go away.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use std::{
    fmt::Write as _,
    io::{BufRead, BufReader, Read, Write},
    process::Stdio,
    thread,
};

use common::{Desk, SPHERE, rows};

const HEADER: &str = "ox,oy,oz,dx,dy,dz\n";

/// A ray that hits the unit sphere; for each number another.
fn write_ray(text: &mut String, number: usize) {
    let height = (number % 1999) as f64 / 2000.0;
    writeln!(text, "5,{},{height},-1,0,0", number as f64 * 1e-9).unwrap();
}

fn rays(count: usize) -> String {
    let mut text = String::from(HEADER);
    (0..count).for_each(|i| write_ray(&mut text, i));
    text
}

#[test]
fn order_is_kept_by_any_number_of_threads() {
    let desk = Desk::new();
    desk.file("it.path", SPHERE).file("rays.csv", rays(30_000));
    let one = desk.run("trace it.path --rays rays.csv --threads 1");
    let found = rows(&one.stdout);
    assert_eq!(found.len(), 30_000);
    assert!(found.iter().enumerate().all(|(i, row)| row.ray == i));
    let four = desk.run("trace it.path --rays rays.csv --threads 4");
    assert!(four.stdout == one.stdout);
}

#[test]
fn hits_before_a_bad_row_are_written() {
    let desk = Desk::new();
    let text = rays(20_000) + "5,0,oops,-1,0,0\n" + rays(20_000).split_once('\n').unwrap().1;
    desk.file("it.path", SPHERE).file("rays.csv", text);
    let outcome = desk.run("trace it.path --rays rays.csv --threads 3");
    assert_eq!(outcome.code, 1);
    assert_eq!(rows(&outcome.stdout).len(), 20_000);
    insta::assert_snapshot!(outcome.stderr);
}

#[test]
fn a_partner_may_wait_for_every_answer() {
    let desk = Desk::new();
    desk.file("it.path", SPHERE);
    let mut child = desk.command("trace it.path --rays -").stdin(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    input.write_all(HEADER.as_bytes()).unwrap();
    assert_eq!(output.next().unwrap().unwrap(), "ray,t,x,y,z,nx,ny,nz,u,v,segment,enters");
    for number in 0..10 {
        let mut ray = String::new();
        write_ray(&mut ray, number);
        input.write_all(ray.as_bytes()).unwrap();
        let answer = output.next().unwrap().unwrap();
        assert!(answer.starts_with(&format!("{number},")), "{answer}");
    }
    drop(input);
    assert!(output.next().is_none());
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let desk = Desk::new();
    desk.file("it.path", SPHERE);
    let mut child = desk.command("trace it.path --rays -").stdin(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let feeder = thread::spawn(move || {
        let text = rays(20_000);
        let rows = text.split_once('\n').unwrap().1;
        input.write_all(HEADER.as_bytes())?;
        loop {
            input.write_all(rows.as_bytes())?;
        }
        #[expect(unreachable_code, reason = "gives the closure its type")]
        std::io::Result::Ok(())
    });
    let mut output = BufReader::new(child.stdout.take().unwrap());
    output.read_line(&mut String::new()).unwrap();
    drop(output);
    assert!(child.wait().unwrap().success());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!(said, "");
    assert_eq!(feeder.join().unwrap().unwrap_err().kind(), std::io::ErrorKind::BrokenPipe);
}

/// The largest memory in use, in bytes, when `count` rays have been traced.
#[cfg(target_os = "linux")]
fn peak_memory(count: usize) -> usize {
    let desk = Desk::new();
    desk.file("it.path", SPHERE);
    let mut command = desk.command("trace it.path --rays - --threads 2");
    let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::with_capacity(1 << 20, child.stdout.take().unwrap());
    let feeder = thread::spawn(move || {
        input.write_all(rays(count).as_bytes()).unwrap();
        input
    });
    let mut line = Vec::new();
    for _ in 0..=count {
        line.clear();
        output.read_until(b'\n', &mut line).unwrap();
    }
    // All is answered, but as the input is still open, the process is still there.
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    drop(feeder.join().unwrap());
    assert!(child.wait().unwrap().success());
    line.split_whitespace().nth(1).unwrap().parse::<usize>().unwrap() << 10
}

/// Input and output of the larger run are 90 MB; what is under way at any time is about 5.
#[test]
#[cfg(target_os = "linux")]
fn memory_does_not_grow_with_the_number_of_rays() {
    let (few, many) = (peak_memory(10_000), peak_memory(500_000));
    assert!(many < few + (24 << 20), "{few} bytes for few rays, {many} for many");
}
