//! Hits as CSV text, every number in the shortest form that reads back as the same f64.

use rondure::{Hit, Ray, Surface};

/// The header of the output.
pub(crate) const HEADER: &[u8] = b"ray,t,x,y,z,nx,ny,nz,u,v\n";

/// Appends the row of one hit of the ray with this number.
pub(crate) fn write_hit(out: &mut Vec<u8>, number: u64, surface: &Surface, ray: &Ray, hit: &Hit) {
    let at = surface.interaction(ray, hit);
    let (p, n, [u, v]) = (at.point, at.normal, at.uv);
    write_integer(out, number);
    for value in [hit.t, p.x, p.y, p.z, n.x, n.y, n.z, u, v] {
        out.push(b',');
        write_number(out, value);
    }
    out.push(b'\n');
}

fn write_number(out: &mut Vec<u8>, value: f64) {
    let mut buffer = ryu::Buffer::new();
    let text = buffer.format(value);
    out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
}

fn write_integer(out: &mut Vec<u8>, value: u64) {
    let mut digits = [0; 20];
    let (mut rest, mut start) = (value, digits.len());
    loop {
        start -= 1;
        digits[start] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[start..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: f64) -> String {
        let mut out = Vec::new();
        write_number(&mut out, value);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "-0"),
            (1.0, "1"),
            (100.0, "100"),
            (0.1, "0.1"),
            (1e300, "1e300"),
            (-2.5e-8, "-2.5e-8"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn numbers_round_trip() {
        // A multiplicative walk through all exponents, with all kinds of mantissas.
        let mut bits = 1_u64;
        for _ in 0..100_000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let value = f64::from_bits(bits);
            if value.is_finite() {
                assert_eq!(number(value).parse::<f64>().unwrap().to_bits(), bits);
            }
        }
    }

    #[test]
    fn integers() {
        for value in [0, 7, 10, 9_999_999, u64::MAX] {
            let mut out = Vec::new();
            write_integer(&mut out, value);
            assert_eq!(String::from_utf8(out).unwrap(), value.to_string());
        }
    }
}
