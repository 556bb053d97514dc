//! Rectangles of pixels, and how a picture is cut into tiles.

/// A rectangle of pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Window {
    /// The first column.
    pub x: u32,
    /// The first row, counted from the top.
    pub y: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl Window {
    /// The whole of a picture.
    pub const fn whole(width: u32, height: u32) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// How many pixels there are.
    pub const fn pixels(&self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// Its pixels, column and row, row by row.
    pub fn coordinates(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let Self { x, y, width, height } = *self;
        (y..y + height).flat_map(move |y| (x..x + width).map(move |x| (x, y)))
    }

    /// The column behind the last one.
    const fn right(&self) -> u64 {
        self.x as u64 + self.width as u64
    }

    /// The row below the last one.
    const fn bottom(&self) -> u64 {
        self.y as u64 + self.height as u64
    }

    /// Whether all of `other` lies in this one.
    pub const fn contains(&self, other: &Self) -> bool {
        self.x <= other.x
            && self.y <= other.y
            && other.right() <= self.right()
            && other.bottom() <= self.bottom()
    }

    /// What both have in common, if that is any pixel.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let right = self.right().min(other.right());
        let bottom = self.bottom().min(other.bottom());
        let width = right.checked_sub(u64::from(x)).filter(|&w| w > 0)?;
        let height = bottom.checked_sub(u64::from(y)).filter(|&h| h > 0)?;
        Some(Self { x, y, width: width as u32, height: height as u32 })
    }

    /// The tiles of this window, row by row: squares of `edge` pixels, cut off at its right and lower border. `edge` is at least 1.
    pub fn tiles(self, edge: u32) -> impl Iterator<Item = Self> + Clone {
        let edge = edge.max(1);
        let steps = move |size: u32| (0..size).step_by(edge as usize);
        steps(self.height).flat_map(move |y| {
            steps(self.width).map(move |x| Self {
                x: self.x + x,
                y: self.y + y,
                width: edge.min(self.width - x),
                height: edge.min(self.height - y),
            })
        })
    }
}

impl core::fmt::Display for Window {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}x{} at {},{}", self.width, self.height, self.x, self.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_window_once() {
        for (window, edge) in [
            (Window { x: 3, y: 5, width: 70, height: 33 }, 32),
            (Window::whole(1, 10_000), 32),
            (Window::whole(16, 16), 100),
            (Window::whole(5, 4), 1),
        ] {
            let mut seen = vec![0; window.pixels() as usize];
            for tile in window.tiles(edge) {
                assert!(window.contains(&tile) && tile.width <= edge && tile.height <= edge);
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        seen[((y - window.y) * window.width + x - window.x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn common_parts() {
        let a = Window { x: 2, y: 2, width: 4, height: 4 };
        let b = Window { x: 5, y: 0, width: 9, height: 3 };
        assert_eq!(a.common(&b), Some(Window { x: 5, y: 2, width: 1, height: 1 }));
        assert_eq!(a.common(&Window { x: 6, ..b }), None);
        assert!(a.contains(&a) && !a.contains(&b));
        let far = Window { x: u32::MAX, y: 0, width: u32::MAX, height: 1 };
        assert_eq!(far.common(&a), None);
    }
}
