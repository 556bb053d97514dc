//! A folder of its own for each test, and the binary run in it.

#![allow(dead_code, reason = "every test file uses a part of it")]

use std::{
    io::Write,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
};

use tempfile::TempDir;

pub(crate) struct Desk {
    folder: TempDir,
}

pub(crate) struct Outcome {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Desk {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
        self
    }

    /// `rondure` with these arguments, which are separated by spaces.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rondure"));
        command
            .args(arguments.split_whitespace())
            .current_dir(self.folder.path())
            .env_remove("CLICOLOR_FORCE")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    pub(crate) fn run(&self, arguments: &str) -> Outcome {
        finish(self.command(arguments).spawn().unwrap())
    }

    pub(crate) fn run_with_input(&self, arguments: &str, input: &[u8]) -> Outcome {
        let mut child = self.command(arguments).stdin(Stdio::piped()).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        thread::scope(|scope| {
            // A process that stops early closes the pipe; that is for the test to judge.
            scope.spawn(move || drop(stdin.write_all(input)));
            finish(child)
        })
    }
}

fn finish(child: Child) -> Outcome {
    let output = child.wait_with_output().unwrap();
    Outcome {
        code: output.status.code().unwrap(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// The bytes of the pixels of a PNG file.
pub(crate) fn pixels(path: &Path) -> Vec<u8> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    data
}

/// One hit of the output of `rondure trace`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) ray: usize,
    pub(crate) t: f64,
    pub(crate) point: [f64; 3],
    pub(crate) normal: [f64; 3],
    pub(crate) uv: [f64; 2],
    pub(crate) segment: usize,
    pub(crate) enters: bool,
}

/// Reads the output of `rondure trace`.
pub(crate) fn rows(csv: &str) -> Vec<Row> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("ray,t,x,y,z,nx,ny,nz,u,v,segment,enters"));
    lines
        .map(|line| {
            let (ray, rest) = line.split_once(',').unwrap();
            let v: Vec<f64> = rest.split(',').map(|x| x.parse().unwrap()).collect();
            let &[t, x, y, z, nx, ny, nz, u, w, segment, enters] = &v[..] else { panic!("{line}") };
            let ray = ray.parse().unwrap();
            let (segment, enters) = (segment as usize, enters == 1.0);
            Row { ray, t, point: [x, y, z], normal: [nx, ny, nz], uv: [u, w], segment, enters }
        })
        .collect()
}

pub(crate) const SPHERE: &str = "M 0 -1 A 1 1 0 0 1 0 1";
pub(crate) const CONE: &str = "M 0 0 L 1 0 L 0 2 Z";
pub(crate) const CYLINDER: &str = "M 0 0 L 1 0 L 1 2 L 0 2 Z";
pub(crate) const TORUS: &str = "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z";
