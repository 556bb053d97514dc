//! Timing: every contestant answers every set of rays, in turn, round after round, so that
//! whatever else the machine does hits all alike.

use cpu_time::ThreadTime;

use super::rays::RaySet;

/// An engine with something to trace.
pub(crate) trait Contestant {
    /// How many of the rays hit; `None` if it cannot answer this kind of set.
    fn answer(&self, set: &RaySet) -> Option<u64>;
}

/// One contestant on one set of rays.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    /// Rays a second, in each round.
    rates: Vec<f64>,
    pub(crate) hits: u64,
}

impl Score {
    /// Rays a second, in the middle of all rounds.
    pub(crate) fn median(&self) -> f64 {
        median(&self.rates)
    }

    /// The slowest and the fastest round.
    pub(crate) fn spread(&self) -> [f64; 2] {
        let fold =
            |f: fn(f64, f64) -> f64| self.rates.iter().copied().reduce(f).unwrap_or(f64::NAN);
        [fold(f64::min), fold(f64::max)]
    }

    /// The rounds of both.
    pub(crate) fn merge(mut self, other: Self) -> Self {
        self.rates.extend(other.rates);
        self
    }
}

/// The number in the middle, or between the two in the middle.
pub(crate) fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

/// Lets all answer all sets, `rounds` times after a round that does not count. The scores are listed
/// by contestant, then by set.
pub(crate) fn heat(
    contestants: &[&dyn Contestant],
    sets: &[RaySet],
    rounds: u32,
) -> Vec<Vec<Option<Score>>> {
    let mut scores = vec![vec![None; sets.len()]; contestants.len()];
    for (j, set) in sets.iter().enumerate() {
        for round in 0..=rounds {
            for (i, contestant) in contestants.iter().enumerate() {
                let start = ThreadTime::now();
                let Some(hits) = contestant.answer(set) else { continue };
                let rate = set.len() as f64 / start.elapsed().as_secs_f64();
                let score = scores[i][j].get_or_insert(Score { rates: Vec::new(), hits });
                if round > 0 {
                    score.rates.push(rate);
                }
            }
        }
    }
    scores
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_and_even_counts() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
    }
}
