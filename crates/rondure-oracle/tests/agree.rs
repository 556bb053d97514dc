//! The wide engine finds what the exact one finds, with every instruction set: the command `agree` in small.

use rondure::engine::Instructions;
use rondure_oracle::agree::{Amount, Failure, compare, shapes, wide};

#[test]
fn wide_agrees_with_exact() -> Result<(), rondure::ProfileError> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let amount = Amount { random: 20_000, adversarial: 20_000, seed: 1, threads };
    let forced = [Instructions::Portable, Instructions::Avx2, Instructions::Avx512];
    let mut failures = Vec::new();
    for shape in shapes()? {
        let entrants = wide(&shape, &forced);
        assert!(!entrants.is_empty());
        for (entrant, count) in entrants.iter().zip(compare(&shape, &entrants, &amount)) {
            assert_eq!(count.rays, amount.random + amount.adversarial);
            assert!(count.hits > 0, "{}: nothing was hit", shape.name);
            if !count.is_clean() {
                for failure in &count.failures {
                    let Failure { kind, words } = failure;
                    failures.push(format!("{} {}, {kind}: {words}", shape.name, entrant.name));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    Ok(())
}
