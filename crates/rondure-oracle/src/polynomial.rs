//! Polynomials with integer coefficients, and their roots in [0, 1], isolated without any rounding.
//!
//! A polynomial is held in the Bernstein basis, all coefficients multiplied by one positive integer,
//! so that sums, products and halvings stay integers. The number of sign changes of the coefficients
//! is the number of roots in the interval or larger by an even number (Descartes' rule in
//! Bernstein form); intervals with more than one change are halved by de Casteljau's algorithm.
//! A single root is then closed in by quadratic interval refinement (Abbott 2006): every bracket
//! is confirmed by two exact signs.
//!
//! Zero counts as positive throughout: the roots found are those of f + epsilon for an
//! infinitesimal epsilon. A double root is two or none, and pieces of one curve that share a vertex
//! agree on its sign.

use dashu_int::IBig;

use crate::exact::shl;

/// The binomial coefficient; n <= 12.
pub fn binomial(n: usize, k: usize) -> i64 {
    (0..k).fold(1, |b, i| b * (n - i) as i64 / (i + 1) as i64)
}

fn lcm_of_binomials(n: usize) -> i64 {
    fn gcd(a: i64, b: i64) -> i64 {
        if b == 0 { a } else { gcd(b, a % b) }
    }
    (0..=n).map(|k| binomial(n, k)).fold(1, |l, b| l / gcd(l, b) * b)
}

/// The Bernstein coefficients of the product of two polynomials given by theirs, multiplied by
/// the least common multiple of the binomial coefficients of the product's degree.
pub fn product(f: &[IBig], g: &[IBig]) -> Vec<IBig> {
    let (m, n) = (f.len() - 1, g.len() - 1);
    let mut sums = vec![IBig::ZERO; m + n + 1];
    for (i, x) in f.iter().enumerate() {
        for (j, y) in g.iter().enumerate() {
            sums[i + j] += x * y * IBig::from(binomial(m, i) * binomial(n, j));
        }
    }
    let multiple = lcm_of_binomials(m + n);
    for (k, sum) in sums.iter_mut().enumerate() {
        *sum *= IBig::from(multiple / binomial(m + n, k));
    }
    sums
}

/// Bernstein coefficients to power coefficients.
pub fn to_power_basis(bernstein: &[IBig]) -> Vec<IBig> {
    let n = bernstein.len() - 1;
    (0..=n)
        .map(|j| {
            (0..=j).fold(IBig::ZERO, |sum, i| {
                let factor = binomial(n, j) * binomial(j, i);
                let signed = if (j - i) % 2 == 0 { factor } else { -factor };
                sum + &bernstein[i] * IBig::from(signed)
            })
        })
        .collect()
}

/// Bernstein coefficients of the derivative, times an integer that the degree alone determines.
pub fn derivative(bernstein: &[IBig]) -> Vec<IBig> {
    bernstein.windows(2).map(|w| &w[1] - &w[0]).collect()
}

/// The value at `x / 2^m`, multiplied by 2^(m degree).
pub fn evaluate(power: &[IBig], x: &IBig, m: i64) -> IBig {
    let n = power.len() - 1;
    let mut sum = power[n].clone();
    for (k, coefficient) in power[..n].iter().rev().enumerate() {
        sum = sum * x + shl(coefficient, m * (k as i64 + 1));
    }
    sum
}

/// Where roots lie: between `low / 2^bits` and `(low + 1) / 2^bits`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bracket {
    /// The lower end, times 2^bits.
    pub low: IBig,
    /// Minus the logarithm of the bracket's width to base 2.
    pub bits: i64,
    /// The number of roots: 1, or more if the roots are closer to each other than can be told
    /// apart at this width; then it is the number of sign changes, an upper bound of the same parity.
    pub changes: usize,
}

impl Bracket {
    /// The middle, as an integer over 2^(bits + 1).
    pub fn middle(&self) -> (IBig, i64) {
        ((&self.low << 1) + IBig::from(1), self.bits + 1)
    }
}

fn negative(x: &IBig) -> bool {
    *x < IBig::ZERO
}

fn sign_changes(bernstein: &[IBig]) -> usize {
    let n = bernstein.len() - 1;
    let mut last = negative(&bernstein[0]);
    let mut changes = 0;
    for (i, b) in bernstein.iter().enumerate().skip(1) {
        if *b == IBig::ZERO && i != n {
            continue;
        }
        changes += usize::from(negative(b) != last);
        last = negative(b);
    }
    changes
}

/// Brackets of width 2^-`target` or less round all roots in [0, 1], in order.
///
/// Intervals that still have several sign changes at width 2^-`limit` are returned as clusters.
pub fn isolate(bernstein: &[IBig], target: i64, limit: i64) -> Vec<Bracket> {
    let mut found = Vec::new();
    let changes = sign_changes(bernstein);
    if changes == 0 {
        return found;
    }
    let power = to_power_basis(bernstein);
    let mut stack = vec![(bernstein.to_vec(), IBig::ZERO, 0_i64)];
    while let Some((coefficients, low, bits)) = stack.pop() {
        let changes = sign_changes(&coefficients);
        if changes == 0 {
            continue;
        }
        if changes == 1 {
            found.push(refine(&power, Bracket { low, bits, changes }, target));
        } else if bits >= limit {
            found.push(Bracket { low, bits, changes });
        } else {
            let (left, right) = halve(coefficients);
            stack.push((right, (&low << 1) + IBig::from(1), bits + 1));
            stack.push((left, low << 1, bits + 1));
        }
    }
    found
}

/// de Casteljau's algorithm at 1/2; both halves are multiplied by 2^degree.
fn halve(mut row: Vec<IBig>) -> (Vec<IBig>, Vec<IBig>) {
    let n = row.len() - 1;
    let (mut left, mut right) = (Vec::with_capacity(n + 1), Vec::with_capacity(n + 1));
    for j in 0..=n {
        left.push(&row[0] << (n - j));
        right.push(&row[n - j] << (n - j));
        for i in 0..n - j {
            let (head, tail) = row.split_at_mut(i + 1);
            head[i] += &tail[0];
        }
    }
    right.reverse();
    (left, right)
}

/// Narrows a bracket with exactly one root to the width 2^-`target`.
fn refine(power: &[IBig], mut bracket: Bracket, target: i64) -> Bracket {
    let degree = (power.len() - 1) as i64;
    let one = IBig::from(1);
    let mut at_low = evaluate(power, &bracket.low, bracket.bits);
    let mut at_high = evaluate(power, &(&bracket.low + &one), bracket.bits);
    let below = negative(&at_low);
    let mut k = 2_i64;
    while bracket.bits < target {
        let m = bracket.bits + k;
        let base = &bracket.low << k as usize;
        let cells = IBig::from(1) << k as usize;
        // The zero of the chord, rounded to a cell boundary strictly inside.
        let chord = &at_low - &at_high;
        let guess = if k == 1 || chord == IBig::ZERO {
            &cells >> 1
        } else {
            ((&at_low << (k as usize + 1)) + &chord) / (&chord << 1)
        };
        let guess = guess.clamp(one.clone(), &cells - &one);
        let x = &base + &guess;
        let value = evaluate(power, &x, m);
        let right_of_x = negative(&value) == below;
        let neighbour = if right_of_x { &x + &one } else { &x - &one };
        let at_neighbour = if neighbour == base {
            shl(&at_low, k * degree)
        } else if neighbour == &base + &cells {
            shl(&at_high, k * degree)
        } else {
            evaluate(power, &neighbour, m)
        };
        if (negative(&at_neighbour) == below) == right_of_x {
            // The root lies beyond the neighbour.
            k = (k / 2).max(1);
            continue;
        }
        bracket.bits = m;
        if right_of_x {
            (bracket.low, at_low, at_high) = (x, value, at_neighbour);
        } else {
            (bracket.low, at_low, at_high) = (neighbour, at_neighbour, value);
        }
        k *= 2;
    }
    bracket
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::to_f64;

    fn integers(xs: &[i64]) -> Vec<IBig> {
        xs.iter().map(|&x| IBig::from(x)).collect()
    }

    /// Power coefficients to Bernstein coefficients, times the common multiple.
    fn from_power(power: &[i64]) -> Vec<IBig> {
        let n = power.len() - 1;
        let multiple = lcm_of_binomials(n);
        (0..=n)
            .map(|k| {
                (0..=k)
                    .map(|j| IBig::from(power[j] * (multiple / binomial(n, j)) * binomial(k, j)))
                    .sum()
            })
            .collect()
    }

    fn middle(b: &Bracket) -> f64 {
        let (x, m) = b.middle();
        to_f64(&x, -m)
    }

    #[test]
    fn finds_the_roots_of_a_sextic() {
        // (10 x - 1)(10 x - 3)(10 x - 5)(10 x - 7)(10 x - 9)(x + 4)
        let factors = [[-1, 10], [-3, 10], [-5, 10], [-7, 10], [-9, 10], [4, 1]];
        let mut power = vec![1_i64];
        for [c, d] in factors {
            let mut next = vec![0; power.len() + 1];
            for (i, p) in power.iter().enumerate() {
                next[i] += c * p;
                next[i + 1] += d * p;
            }
            power = next;
        }
        let roots: Vec<_> = isolate(&from_power(&power), 120, 60).iter().map(middle).collect();
        assert_eq!(roots.len(), 5);
        for (root, expected) in roots.iter().zip([0.1, 0.3, 0.5, 0.7, 0.9]) {
            assert!((root - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn bisection_agrees_with_refinement() {
        // x^5 + 3 x^2 - 1
        let bernstein = from_power(&[-1, 0, 3, 0, 0, 1]);
        let power = to_power_basis(&bernstein);
        let bracket = isolate(&bernstein, 100, 60).remove(0);
        let (mut low, mut bits) = (IBig::ZERO, 0);
        while bits < bracket.bits {
            bits += 1;
            low <<= 1;
            let middle = &low + IBig::from(1);
            if negative(&evaluate(&power, &middle, bits)) {
                low = middle;
            }
        }
        assert_eq!(low, bracket.low);
    }

    #[test]
    fn zero_counts_as_positive() {
        // x (x - 1): f + epsilon has both its roots just inside.
        assert_eq!(isolate(&from_power(&[0, -1, 1]), 60, 60).len(), 2);
        // x (1 - x): both just outside.
        assert!(isolate(&from_power(&[0, 1, -1]), 60, 60).is_empty());
        assert!(isolate(&integers(&[0, 0, 0]), 60, 60).is_empty());
        // -(3 x - 1)^2 touches zero: a cluster of two; its negative as well.
        let cluster = isolate(&from_power(&[-1, 6, -9]), 60, 40);
        assert!(cluster.len() == 1 && cluster[0].changes == 2 && cluster[0].bits == 40);
    }
}
