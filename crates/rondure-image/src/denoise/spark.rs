//! Pixels that hold one stray sample: sparks, or fireflies.
//!
//! A pixel of n samples, one of which is much brighter than all the others, has about the variance (l - m)^2 of its mean, l being its light and m
//! that of the others: it says of itself that it knows no more than one sample. Where all around are dark and sure of it, such a pixel tells
//! nothing of what is seen there. To average it over those that look alike would draw its light along their edges.

use super::Scene;

/// How far the pixels lie that tell what a spark's light should be.
const REACH: i32 = 2;
/// A spark is made of less than so many samples: its variance is more than this share of the square of what it is brighter.
const SAMPLES: f32 = 3.0;
/// By how many standard deviations of those around it is brighter.
const SIGNIFICANT: f32 = 8.0;
/// How many times as much brighter as any of the eight pixels next to it: what is seen through glass, and caustics, are made of many
/// such samples, and are no sparks.
const ALONE: f32 = 3.0;

/// Whether each pixel is a spark.
pub(super) fn sparks(scene: &Scene) -> Vec<bool> {
    let [width, height] = scene.size;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    pixels.map(|p| (0..3).any(|channel| is_spark(scene, p, channel))).collect()
}

fn is_spark(scene: &Scene, [x, y]: [i32; 2], channel: usize) -> bool {
    let i = scene.index([x, y]);
    let (light, variance) = (scene.light[i][channel], scene.variance[i][channel]);
    // Most pixels are ruled out by this: nobody is brighter than its own light.
    if !scene.known[i] || variance * SAMPLES <= 0.0 {
        return false;
    }
    let mut lights = [0.0; ((2 * REACH + 1) * (2 * REACH + 1) - 1) as usize];
    let (mut variances, mut count, mut next) = (lights, 0, 0.0_f32);
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let q = [x + dx, y + dy];
            if [dx, dy] == [0, 0] || !scene.is_inside(q) || !scene.known[scene.index(q)] {
                continue;
            }
            let q = scene.index(q);
            (lights[count], variances[count]) =
                (scene.light[q][channel], scene.variance[q][channel]);
            if dx.abs().max(dy.abs()) == 1 {
                next = next.max(lights[count]);
            }
            count += 1;
        }
    }
    if count == 0 {
        return false;
    }
    let middle = median(&mut lights[..count]);
    let excess = light - middle;
    excess > 0.0
        && variance * SAMPLES > excess * excess
        && excess > ALONE * (next - middle)
        && excess * excess > SIGNIFICANT * SIGNIFICANT * median(&mut variances[..count])
}

/// The middle one of some numbers.
fn median(numbers: &mut [f32]) -> f32 {
    let middle = numbers.len() / 2;
    *numbers.select_nth_unstable_by(middle, f32::total_cmp).1
}
