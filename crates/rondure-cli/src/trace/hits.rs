//! Answers as CSV text, every number in the shortest form that reads back as the same f64.

use rondure::{
    Hit, Interaction, Ray, Solid, Surface, Vec3,
    solid::{Boundary, Span},
};

/// The header of hits.
pub(crate) const HITS: &[u8] = b"ray,t,x,y,z,nx,ny,nz,u,v,segment,enters\n";

/// The header of spans.
pub(crate) const SPANS: &[u8] = b"ray,\
    enter_t,enter_x,enter_y,enter_z,enter_nx,enter_ny,enter_nz,enter_u,enter_v,enter_segment,\
    exit_t,exit_x,exit_y,exit_z,exit_nx,exit_ny,exit_nz,exit_u,exit_v,exit_segment\n";

/// The header of what is in the way.
pub(crate) const OCCLUDED: &[u8] = b"ray,occluded\n";

/// Appends the row of one hit of the ray with this number.
pub(crate) fn write_hit(out: &mut Vec<u8>, number: u64, surface: &Surface, ray: &Ray, hit: &Hit) {
    let at = surface.interaction(ray, hit);
    write_integer(out, number);
    write_place(out, hit.t, &at, surface.segment(hit));
    let enters = at.normal.dot(ray.direction) < 0.0;
    out.extend_from_slice(if enters { b",1\n" } else { b",0\n" });
}

/// Appends the row of one span of the ray with this number.
pub(crate) fn write_span(out: &mut Vec<u8>, number: u64, solid: &Solid, ray: &Ray, span: &Span) {
    write_integer(out, number);
    for Boundary { t, wall } in [&span.enter, &span.exit] {
        match wall {
            Some(wall) => {
                let segment = solid.surface().segment(&wall.hit);
                write_place(out, *t, &solid.interaction(ray, wall), segment);
            }
            // The ray begins or ends here: there is no surface.
            None => {
                let p = ray.at(*t);
                write_numbers(out, &[*t, p.x, p.y, p.z]);
                out.extend_from_slice(b",,,,,,");
            }
        }
    }
    out.push(b'\n');
}

/// Appends the row that says whether anything is in the way of the ray with this number.
pub(crate) fn write_occluded(out: &mut Vec<u8>, number: u64, occluded: bool) {
    write_integer(out, number);
    out.extend_from_slice(if occluded { b",1\n" } else { b",0\n" });
}

fn write_place(out: &mut Vec<u8>, t: f64, at: &Interaction, segment: usize) {
    let (Vec3 { x, y, z }, n, [u, v]) = (at.point, at.normal, at.uv);
    write_numbers(out, &[t, x, y, z, n.x, n.y, n.z, u, v]);
    out.push(b',');
    write_integer(out, segment as u64);
}

fn write_numbers(out: &mut Vec<u8>, values: &[f64]) {
    for value in values {
        out.push(b',');
        write_number(out, *value);
    }
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
