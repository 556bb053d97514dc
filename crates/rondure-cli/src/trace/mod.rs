//! `rondure trace`: rays in, hits out, both as CSV, in a stream.
//!
//! [`blocks`] reads ahead on its own thread; the blocks at hand are parsed ([`rays`]), traced and
//! put into text ([`hits`]) on all cores; another thread writes them in order. Only a fixed number
//! of blocks is under way at any time, so memory does not grow with the number of rays.

mod blocks;
mod hits;
mod rays;

use std::{
    fs::File,
    io::{self, Read, Write},
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{Receiver, SyncSender, sync_channel},
    },
    thread,
};

use clap::{Args, ValueEnum};
use rayon::prelude::*;
use rondure::{FillRule, Hit, Ray, Solid, Surface, solid::Span};

use self::{
    blocks::{LONGEST_LINE, ReadError, read_ahead},
    rays::{Columns, LineError, Parsed},
};
use crate::{
    engine::EngineArgs,
    failure::{Excerpt, Failure, report},
    profile::ProfileArgs,
    threads::Threads,
};

/// Print where rays meet the surface that a profile sweeps round the z axis
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct Trace {
    #[command(flatten)]
    profile: ProfileArgs,

    /// The rays: a CSV file, or - for standard input
    #[arg(long, value_name = "RAYS.csv")]
    rays: PathBuf,

    /// Print all hits of a ray, not just the closest
    #[arg(long, group = "answer")]
    all: bool,

    /// Print the stretches of a ray inside the solid that a closed profile bounds
    #[arg(long, group = "answer")]
    spans: bool,

    /// Print for each ray whether it hits anything in its range
    #[arg(long, group = "answer")]
    occluded: bool,

    /// Spans: what is inside where the profile crosses itself; nonzero if not given
    #[arg(long, value_enum, requires = "spans")]
    fill_rule: Option<FillRuleName>,

    #[command(flatten)]
    engine: EngineArgs,

    #[command(flatten)]
    threads: Threads,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum FillRuleName {
    /// What the profile winds round
    Nonzero,
    /// What it encloses an odd number of times
    Evenodd,
}

const HELP: &str = "\
Rays:
  The first line names the columns: ox,oy,oz (the origin), dx,dy,dz (the direction, of any length
  but 0) and, if wanted, tmin,tmax (the range in which hits count, in units of the direction; 0 to
  infinity if not given; inf and -inf are numbers here). They may stand in any order; other columns
  are an error. Each further line is a ray; empty lines are skipped and not counted.

Output:
  A line for each hit: ray,t,x,y,z,nx,ny,nz,u,v,segment,enters, where ray counts from 0, t is in
  units of the direction and grows along a ray, (nx,ny,nz) is the unit normal, out of a solid, u the
  angle round the axis over 2 pi, v the fraction of the profile's length, segment the number of the
  profile's segment, from 0, and enters 1 if the ray comes from the side of the normal, otherwise 0.
  A ray without hits has no line. Every number reads back as exactly the same f64.

  --spans: a line for each stretch inside the solid: ray, and t to segment twice, enter_t,.. where
  it begins and exit_t,.. where it ends. It is never without its end, however the ray runs. Where
  the range of the ray begins or ends inside, there is a point but no surface: the other columns are
  empty.

  --occluded: a line for each ray: ray,occluded, which is 1 if it hits anything in its range.

Examples:
  printf 'ox,oy,oz,dx,dy,dz\\n9,0,1,-1,0,0\\n' | rondure trace goblet.path --rays -
  rondure trace goblet.path --rays rays.csv > hits.csv
  rondure trace bowl.path --thickness 0.1 --rays rays.csv --spans
  rondure trace vase.svg --svg-id outline --axis 105 --scale 0.1 --rays rays.csv --all
  make-rays | rondure trace outline.csv --spline natural --rays - | head";

/// How many blocks are worked on at once for each thread: enough that no thread waits long for the
/// last one.
const BLOCKS_PER_THREAD: usize = 8;

impl Trace {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let surface = Surface::with_engine(&self.profile.read()?, &self.engine.options());
        let answer = self.answer(Arc::new(surface))?;
        let (name, input) = open(&self.rays)?;
        let pool = self.threads.pool()?;
        let at_once = BLOCKS_PER_THREAD * pool.current_num_threads();
        let blocks = read_ahead(input, at_once);

        let mut first = match blocks.recv() {
            Ok(Ok(block)) => block,
            Ok(Err(error)) => return Err(unreadable(&name, &error, 1, 0)),
            Err(_) => return Err(no_header(&name)),
        };
        let end = first.iter().position(|&b| b == b'\n').map_or(first.len(), |i| i + 1);
        let rest = first.split_off(end);
        let columns = Columns::from_header(&first).map_err(|e| bad_line(&name, &e, 1, 0))?;

        let tracer = Tracer { answer: &answer, columns: &columns };
        thread::scope(|scope| {
            let (sender, receiver) = sync_channel(1);
            let header = answer.header();
            let writer = scope.spawn(move || write(header, &receiver));
            let outcome = pool.install(|| tracer.stream(&name, rest, blocks, at_once, sender));
            match writer.join() {
                Ok(written) => written.map_err(|e| Failure::output(&e)).and(outcome),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    }
}

impl Trace {
    fn answer(&self, surface: Arc<Surface>) -> Result<Answer, Failure> {
        if self.spans {
            let rule = match self.fill_rule {
                Some(FillRuleName::Evenodd) => FillRule::EvenOdd,
                Some(FillRuleName::Nonzero) | None => FillRule::NonZero,
            };
            let solid = Solid::from_surface(surface, rule).map_err(|e| {
                let name = self.profile.path().display();
                Failure::new(
                    format!("`{name}`: --spans needs a solid, and {e}"),
                    "end the profile on the axis or close it with Z, or give it a --thickness",
                )
            })?;
            return Ok(Answer::Spans(Box::new(solid)));
        }
        Ok(match (self.all, self.occluded) {
            (true, _) => Answer::All(surface),
            (_, true) => Answer::Occluded(surface),
            _ => Answer::Closest(surface),
        })
    }
}

/// What is asked of every ray, and of what.
enum Answer {
    Closest(Arc<Surface>),
    All(Arc<Surface>),
    Spans(Box<Solid>),
    Occluded(Arc<Surface>),
}

/// Room that is used again for the next ray.
#[derive(Default)]
struct Room {
    hits: Vec<Hit>,
    spans: Vec<Span>,
}

impl Answer {
    fn header(&self) -> &'static [u8] {
        match self {
            Self::Closest(_) | Self::All(_) => hits::HITS,
            Self::Spans(_) => hits::SPANS,
            Self::Occluded(_) => hits::OCCLUDED,
        }
    }

    /// Appends the rows of one ray.
    fn write(&self, out: &mut Vec<u8>, number: u64, ray: &Ray, room: &mut Room) {
        match self {
            Self::Closest(surface) => {
                if let Some(hit) = surface.closest(ray) {
                    hits::write_hit(out, number, surface, ray, &hit);
                }
            }
            Self::All(surface) => {
                surface.all(ray, &mut room.hits);
                for hit in &room.hits {
                    hits::write_hit(out, number, surface, ray, hit);
                }
            }
            Self::Spans(solid) => {
                solid.spans(ray, &mut room.spans);
                for span in &room.spans {
                    hits::write_span(out, number, solid, ray, span);
                }
            }
            Self::Occluded(surface) => hits::write_occluded(out, number, surface.any(ray)),
        }
    }
}

struct Tracer<'a> {
    answer: &'a Answer,
    columns: &'a Columns,
}

impl Tracer<'_> {
    /// Works through all blocks, as many at once as are there, up to `at_once`, and hands their
    /// output on in order.
    fn stream(
        &self,
        name: &str,
        first: Vec<u8>,
        blocks: Receiver<Result<Vec<u8>, ReadError>>,
        at_once: usize,
        sender: SyncSender<Vec<Vec<u8>>>,
    ) -> Result<(), Failure> {
        let (mut line, mut ray) = (2, 0);
        let mut batch = vec![first];
        loop {
            let mut unread = None;
            while batch.len() < at_once {
                match blocks.try_recv() {
                    Ok(Ok(block)) => batch.push(block),
                    Ok(Err(error)) => {
                        unread = Some(error);
                        break;
                    }
                    Err(_) => break,
                }
            }
            let mut parsed: Vec<_> = batch.par_iter().map(|b| self.columns.parse(b)).collect();
            if let Some(bad) = parsed.iter().position(|p| p.error.is_some()) {
                parsed.truncate(bad + 1);
            }
            let firsts: Vec<u64> = parsed
                .iter()
                .scan(ray, |next, p| Some(std::mem::replace(next, *next + p.rays.len() as u64)))
                .collect();
            line += parsed.iter().map(|p| p.lines).sum::<usize>();
            ray += parsed.iter().map(|p| p.rays.len() as u64).sum::<u64>();
            let output = parsed
                .par_iter()
                .zip(firsts)
                .map_init(Room::default, |room, (parsed, first)| self.trace(parsed, first, room))
                .collect();
            if sender.send(output).is_err() {
                // The writer has failed, and says why itself.
                return Ok(());
            }
            if let Some(error) = parsed.pop().and_then(|p| p.error) {
                return Err(bad_line(name, &error, line, ray));
            }
            let next = match unread {
                Some(error) => Err(error),
                None => match blocks.recv() {
                    Ok(next) => next,
                    Err(_) => return Ok(()),
                },
            };
            match next {
                Ok(block) => batch = vec![block],
                Err(error) => return Err(unreadable(name, &error, line, ray)),
            }
        }
    }

    /// The output for some rays, the first of which has the number `first`.
    fn trace(&self, parsed: &Parsed, first: u64, room: &mut Room) -> Vec<u8> {
        let mut out = Vec::new();
        for (number, ray) in (first..).zip(&parsed.rays) {
            self.answer.write(&mut out, number, ray, room);
        }
        out
    }
}

/// Writes everything to standard output, as soon as it is there.
fn write(header: &[u8], output: &Receiver<Vec<Vec<u8>>>) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(header)?;
    for batch in output {
        for text in batch {
            out.write_all(&text)?;
        }
        out.flush()?;
    }
    out.flush()
}

/// The name for messages, and the stream.
fn open(path: &Path) -> Result<(String, Box<dyn Read + Send>), Failure> {
    if path == Path::new("-") {
        return Ok(("standard input".into(), Box::new(io::stdin())));
    }
    let name = path.display().to_string();
    match File::open(path) {
        Ok(file) => Ok((name, Box::new(file))),
        Err(error) => Err(Failure::unreadable(&name, &error)),
    }
}

fn no_header(name: &str) -> Failure {
    Failure::new(
        format!("`{name}` is empty"),
        "the first line must name the columns: ox,oy,oz,dx,dy,dz; each further line is a ray",
    )
}

fn bad_line(name: &str, error: &LineError, line: usize, rays: u64) -> Failure {
    let LineError { text, span, label, .. } = error;
    let excerpt = Excerpt { name, line, text, span: span.clone(), label };
    report(&error.title, &excerpt, &error.help, written(rays).as_deref())
}

fn unreadable(name: &str, error: &ReadError, line: usize, rays: u64) -> Failure {
    let failure = match error {
        ReadError::Io(error) => Failure::unreadable(name, error),
        ReadError::LongLine => Failure::new(
            format!("`{name}`: line {line} is longer than {LONGEST_LINE} bytes"),
            "give a CSV text with one ray on each line",
        ),
    };
    match written(rays) {
        Some(note) => failure.with_note(&note),
        None => failure,
    }
}

/// What has become of the rays before an error.
fn written(rays: u64) -> Option<String> {
    match rays {
        0 => None,
        1 => Some("the hits of the ray before it have been written".into()),
        _ => Some(format!("the hits of the {rays} rays before it have been written")),
    }
}
