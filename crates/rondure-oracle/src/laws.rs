//! The laws of sets on random solids: that A - A is nothing, De Morgan's and the others, and that what is
//! in a union and in an intersection adds up.
//!
//! Solids are turned profiles of every kind, spheres, boxes, half spaces and what is made of two of them,
//! placed anyhow. In every other round their measures are multiples of 1/2, so that many faces coincide,
//! and rays run along axes, through edges and within faces.

use core::fmt;
use std::sync::Arc;

use rondure::{
    Affine, FillRule, Ray, Solid, Vec3,
    numeric::gamma,
    solid::{Compound, Csg},
};

use crate::{
    Random,
    solids::{RULES, ends, known, random_ray, random_solid},
};

/// How many rays are shot at the same solids.
pub const RAYS_PER_ROUND: u64 = 100;

/// Solids are about 2 large. Near a tangency, and where several faces at the same place differ in which
/// gives its t, ends of spans differ by less than this.
const THIN: f64 = 1e-6;

/// As many failures are told in words.
const TOLD: usize = 10;

/// Rays are cut so far from the origin: half spaces have no end.
const FAR: f64 = 20.0;

/// Two expressions in A, B and C that are the same set.
type Same = fn(&Csg, &Csg, &Csg) -> [Csg; 2];

const SAME: [(&str, Same); 10] = [
    ("C - (A + B) = (C - A) * (C - B)", |a, b, c| {
        [less(c, &plus(a, b)), times(&less(c, a), &less(c, b))]
    }),
    ("C - (A * B) = (C - A) + (C - B)", |a, b, c| {
        [less(c, &times(a, b)), plus(&less(c, a), &less(c, b))]
    }),
    ("A * (B + C) = A * B + A * C", |a, b, c| {
        [times(a, &plus(b, c)), plus(&times(a, b), &times(a, c))]
    }),
    ("A + (B * C) = (A + B) * (A + C)", |a, b, c| {
        [plus(a, &times(b, c)), times(&plus(a, b), &plus(a, c))]
    }),
    ("(A + B) + C = A + B + C", |a, b, c| {
        [plus(&plus(a, b), c), Csg::Union(vec![a.clone(), b.clone(), c.clone()])]
    }),
    ("(A - B) - C = A - (B + C)", |a, b, c| {
        [Csg::Difference(vec![a.clone(), b.clone(), c.clone()]), less(a, &plus(b, c))]
    }),
    ("A + A = A", |a, _, _| [plus(a, a), a.clone()]),
    ("A * A = A", |a, _, _| [times(a, a), a.clone()]),
    ("A + (A * B) = A", |a, b, _| [plus(a, &times(a, b)), a.clone()]),
    ("A * B = B * A", |a, b, _| [times(a, b), times(b, a)]),
];

/// An expression in A and B that is nothing.
type Nothing = fn(&Csg, &Csg) -> Csg;

const NOTHING: [(&str, Nothing); 3] = [
    ("A - A = 0", |a, _| less(a, a)),
    ("A - (B + A) = 0", |a, b| less(a, &plus(b, a))),
    ("(A * B) - A = 0", |a, b| less(&times(a, b), a)),
];

const LENGTHS: [&str; 2] = ["|A + B| + |A * B| = |A| + |B|", "|A - B| + |A * B| = |A|"];

fn plus(a: &Csg, b: &Csg) -> Csg {
    a.clone().union(b.clone())
}

fn times(a: &Csg, b: &Csg) -> Csg {
    a.clone().intersection(b.clone())
}

fn less(a: &Csg, b: &Csg) -> Csg {
    a.clone().difference(b.clone())
}

/// What came of one law.
#[derive(Clone, Debug)]
pub struct Law {
    /// The law; +, * and - are union, intersection and difference, |A| is the length of a ray in A.
    pub name: &'static str,
    /// The spans that were compared, or found in A and B.
    pub spans: u64,
    /// The rays for which it did not hold.
    pub broken: u64,
    /// The largest difference of two t, beyond their own rounding, or of two lengths.
    pub worst: f64,
}

/// What came of all laws.
#[derive(Clone, Debug)]
pub struct Laws {
    /// The rays.
    pub rays: u64,
    /// The triples of solids.
    pub rounds: u64,
    /// The sums of all lengths in A + B and A * B, and in A and B: volumes, up to a factor.
    pub volumes: [f64; 2],
    /// Each law.
    pub laws: Vec<Law>,
    /// The first few failures, in words.
    pub failures: Vec<String>,
}

impl Default for Laws {
    fn default() -> Self {
        let names = SAME.iter().map(|law| law.0).chain(NOTHING.iter().map(|law| law.0));
        let laws = names
            .chain(LENGTHS)
            .map(|name| Law { name, spans: 0, broken: 0, worst: 0.0 })
            .collect();
        Self { rays: 0, rounds: 0, volumes: [0.0; 2], laws, failures: Vec::new() }
    }
}

impl Laws {
    /// Whether all of them held.
    pub fn hold(&self) -> bool {
        self.laws.iter().all(|law| law.broken == 0)
    }

    /// Shoots rays: 100 at each of so many triples of random solids.
    pub fn try_on(&mut self, rounds: u64, random: &mut Random) {
        for _ in 0..rounds {
            self.round(random);
        }
    }

    fn round(&mut self, random: &mut Random) {
        let aligned = self.rounds.is_multiple_of(2);
        self.rounds += 1;
        let [a, b, c] = [(); 3].map(|()| operand(random, aligned));
        let built = |csg: Csg| known(csg.build());
        let same = SAME.map(|(_, sides)| sides(&a, &b, &c).map(built));
        let nothing = NOTHING.map(|(_, side)| built(side(&a, &b)));
        let measured = [plus(&a, &b), times(&a, &b), less(&a, &b), a, b].map(built);
        for _ in 0..RAYS_PER_ROUND {
            let ray = random_ray(random, aligned);
            self.rays += 1;
            self.sides(&ray, &same);
            for (i, compound) in nothing.iter().enumerate() {
                let found = ends(compound, &ray);
                self.tell(SAME.len() + i, found.len(), (!found.is_empty()).then_some(0.0), &ray);
            }
            self.lengths(&ray, &measured);
        }
    }

    fn sides(&mut self, ray: &Ray, same: &[[Compound; 2]]) {
        for (law, sides) in same.iter().enumerate() {
            let [x, y] = sides.each_ref().map(|side| ends(side, ray));
            let pairs = || x.iter().flatten().zip(y.iter().flatten());
            // Nearly parallel to a plane, a ray passes it so far away that an ulp of t is long.
            let ulps = |a: f64| gamma(4) * a.abs();
            let apart = |(a, b): (&f64, &f64)| {
                if a == b { 0.0 } else { ((a - b).abs() - ulps(*a)).max(0.0) }
            };
            let worst = pairs().map(apart).fold(0.0, f64::max);
            self.laws[law].worst = self.laws[law].worst.max(worst);
            let broken = x.len() != y.len() || worst >= THIN;
            self.tell(law, x.len() + y.len(), broken.then_some(worst), ray);
        }
    }

    fn lengths(&mut self, ray: &Ray, measured: &[Compound; 5]) {
        let ray = ray.with_range(-FAR, FAR);
        let mut spans = 0;
        let [union, intersection, difference, of_a, of_b] = measured.each_ref().map(|compound| {
            let ends = ends(compound, &ray);
            spans += ends.len();
            ends.iter().map(|[from, to]| to - from).sum::<f64>()
        });
        let sums = [[union + intersection, of_a + of_b], [difference + intersection, of_a]];
        self.volumes[0] += sums[0][0];
        self.volumes[1] += sums[0][1];
        for (i, [x, y]) in sums.into_iter().enumerate() {
            let law = SAME.len() + NOTHING.len() + i;
            let off = (x - y).abs();
            self.laws[law].worst = self.laws[law].worst.max(off);
            let broken = off.is_nan() || off >= THIN;
            self.tell(law, spans, broken.then_some(off), &ray);
        }
    }

    /// Counts a ray for a law; `broken` says by how much it did not hold.
    fn tell(&mut self, law: usize, spans: usize, broken: Option<f64>, ray: &Ray) {
        let law = &mut self.laws[law];
        law.spans += spans as u64;
        if let Some(off) = broken {
            law.broken += 1;
            if self.failures.len() < TOLD {
                let round = self.rounds;
                self.failures.push(format!("{}: round {round}, off by {off:e}: {ray:?}", law.name));
            }
        }
    }
}

/// A random solid: of [`random_solid`], of a random profile, or made of two.
fn operand(random: &mut Random, aligned: bool) -> Csg {
    match random.below(8) {
        0 | 1 => turned(random),
        2 => {
            let [a, b] = [(); 2].map(|()| random_solid(random, aligned));
            [Csg::union, Csg::intersection, Csg::difference][random.below(3)](a, b)
        }
        _ => random_solid(random, aligned),
    }
}

/// The solid of a random closed profile, placed anyhow.
fn turned(random: &mut Random) -> Csg {
    let profile = loop {
        let profile = random.profile();
        if profile.bounds_solid() {
            break profile;
        }
    };
    let rule: FillRule = RULES[random.below(2)];
    let solid = Csg::turned(Arc::new(known(Solid::new(&profile, rule))));
    let turn = Affine::rotate(random.direction(), random.within(0.0, 6.0));
    let size = Affine::scale(Vec3::splat(random.within(0.7, 1.5)));
    solid.placed(&Affine::translate(random.cube() * 0.6).after(&turn.after(&size)))
}

impl fmt::Display for Laws {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} rays at {} triples of random solids A, B, C", self.rays, self.rounds)?;
        for Law { name, spans, broken, worst } in &self.laws {
            writeln!(f, "  {name:<34} {spans:>12} spans {broken:>4} broken   worst {worst:.1e}")?;
        }
        let [x, y] = self.volumes;
        write!(f, "  lengths of all rays: {x} in A + B and A * B, {y} in A and B")?;
        self.failures.iter().try_for_each(|failure| write!(f, "\n  {failure}"))
    }
}
