//! What came of comparing engines on many rays.

/// How many failures of a kind are kept in words.
const WORDS: usize = 3;

/// What came of many rays. All counts are of rays but `hits`, `grazing` and `joint`.
#[derive(Clone, Debug, Default)]
pub struct Count {
    /// Rays compared.
    pub rays: u64,
    /// Hits of the exact engine.
    pub hits: u64,
    /// Rays with a hit that only the exact engine has.
    pub lost: u64,
    /// Rays with a hit that only the other engine has.
    pub extra: u64,
    /// Rays with a hit on another piece.
    pub other: u64,
    /// Rays with a hit that is farther off than rounding explains.
    pub off: u64,
    /// The largest |dt| |d| / R of those.
    pub off_worst: f64,
    /// Rays for which the engine's answers are wrong in themselves: not in order, not in the range, an odd
    /// number of hits of a line with a solid, or `any` without a hit.
    pub inconsistent: u64,
    /// The largest |dt| |d| / R of all that are the same, last places of t left out.
    pub worst: f64,
    /// Hits that are the same by the bound on grazing rays only.
    pub grazing: u64,
    /// The largest |dt| |d| / R among those, and the largest sine of the incidence.
    pub grazing_worst: [f64; 2],
    /// Rays that touch, to within rounding.
    pub tangent: u64,
    /// The largest distance of such a ray from a tangency, as a share of the size.
    pub tangent_worst: f64,
    /// Hits given to the other piece at a joint.
    pub joint: u64,
    /// Rays with a hit at an end of the range.
    pub end: u64,
    /// Rays with another closest hit, as near as rounding can tell.
    pub tie: u64,
    /// The first few disagreements of each kind.
    pub failures: Vec<Failure>,
}

/// A disagreement.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Of what kind or kinds.
    pub kind: String,
    /// The ray and all answers.
    pub words: String,
}

fn keep(failures: &mut Vec<Failure>, more: impl IntoIterator<Item = Failure>) {
    for failure in more {
        if has_room(failures, &failure.kind) {
            failures.push(failure);
        }
    }
}

/// Whether one more failure of a kind may be kept.
pub(super) fn has_room(failures: &[Failure], kind: &str) -> bool {
    failures.iter().filter(|f| f.kind == kind).count() < WORDS
}

impl Count {
    /// Whether there was no disagreement.
    pub fn is_clean(&self) -> bool {
        self.lost + self.extra + self.other + self.off + self.inconsistent == 0
    }

    /// Adds the counts of further rays.
    pub fn add(&mut self, more: Self) {
        for (own, more) in [
            (&mut self.rays, more.rays),
            (&mut self.hits, more.hits),
            (&mut self.lost, more.lost),
            (&mut self.extra, more.extra),
            (&mut self.other, more.other),
            (&mut self.off, more.off),
            (&mut self.inconsistent, more.inconsistent),
            (&mut self.grazing, more.grazing),
            (&mut self.tangent, more.tangent),
            (&mut self.joint, more.joint),
            (&mut self.end, more.end),
            (&mut self.tie, more.tie),
        ] {
            *own += more;
        }
        self.worst = self.worst.max(more.worst);
        self.off_worst = self.off_worst.max(more.off_worst);
        self.tangent_worst = self.tangent_worst.max(more.tangent_worst);
        for (own, more) in self.grazing_worst.iter_mut().zip(more.grazing_worst) {
            *own = own.max(more);
        }
        keep(&mut self.failures, more.failures);
    }
}
