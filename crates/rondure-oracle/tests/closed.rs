//! The soak at closed profiles in small.

use rondure::Method;
use rondure_oracle::closed::{Soak, soak};

#[test]
fn closed_profiles_are_hit_an_even_number_of_times() {
    let plan = Soak { rays: 400_000, compared: 4_000, seed: 3, threads: 2, method: Method::Wide };
    match soak(&plan, &|_| ()) {
        Ok(tally) => {
            println!("{tally}");
            tally.assert_clean();
            assert!(tally.rays >= plan.rays && tally.compared > plan.compared / 2, "{tally}");
            assert!(tally.leaving > 10_000 && tally.tangent > 10, "{tally}");
        }
        Err(error) => unreachable!("{error}"),
    }
}
