//! PFM files: three 32-bit floats a pixel behind three lines of text, rows from the bottom (Debevec's "portable float map"). What denoisers take and give.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use crate::{Image, file::write_whole};

/// Why a file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        source: io::Error,
    },
    /// The file holds no picture in colour, or not all of it.
    #[error("{} is no whole PFM picture in colour", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
    },
}

/// Writes three floats of each pixel, rows given from the top.
///
/// # Errors
/// If the disk says no; nothing is left behind then.
pub fn write(
    path: impl AsRef<Path>,
    [width, height]: [u32; 2],
    pixels: &[[f32; 3]],
) -> io::Result<()> {
    write_whole(path.as_ref(), |out| {
        // Less than 0: the least significant byte comes first.
        write!(out, "PF\n{width} {height}\n-1.0\n")?;
        for row in pixels.chunks_exact(width.max(1) as usize).rev() {
            row.iter().flatten().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
        }
        Ok(())
    })
}

/// Reads a picture in colour.
///
/// # Errors
/// If the file cannot be read, or holds something else or not all of it.
pub fn read(path: impl AsRef<Path>) -> Result<Image, ReadError> {
    let path = path.as_ref();
    let bytes = fs::read(path).map_err(|source| ReadError::Io { path: path.to_owned(), source })?;
    parse(&bytes).ok_or_else(|| ReadError::Invalid { path: path.to_owned() })
}

fn parse(bytes: &[u8]) -> Option<Image> {
    let mut rest = bytes;
    let mut word = || {
        let end = rest.iter().position(u8::is_ascii_whitespace)?;
        let word = str::from_utf8(&rest[..end]).ok()?;
        rest = &rest[end + 1..];
        Some(word)
    };
    let kind = word()?;
    let (width, height): (u32, u32) = (word()?.parse().ok()?, word()?.parse().ok()?);
    let scale: f32 = word()?.parse().ok()?;
    let expected = u64::from(width) * u64::from(height) * 12;
    if kind != "PF" || expected == 0 || rest.len() as u64 != expected {
        return None;
    }
    let float = |bytes: &[u8]| {
        let bytes = bytes.try_into().unwrap_or_default();
        if scale < 0.0 { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) }
    };
    let pixel = |bytes: &[u8]| [float(&bytes[..4]), float(&bytes[4..8]), float(&bytes[8..])];
    let rows = rest.chunks_exact(width as usize * 12).rev();
    let pixels = rows.flat_map(|row| row.chunks_exact(12).map(pixel)).collect();
    Image::new(width, height, pixels).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pfm");
        let pixels: Vec<_> = (0..15).map(|i| [i as f32, -0.5, 1e-30 * i as f32]).collect();
        write(&path, [5, 3], &pixels).unwrap();
        assert_eq!(read(&path).unwrap().pixels(), pixels);
        // The last row comes first.
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"PF\n5 3\n-1.0\n\0\0\x20\x41"));
        for length in 0..bytes.len() {
            assert!(parse(&bytes[..length]).is_none(), "{length}");
        }
        assert!(parse(&[bytes.as_slice(), b"x"].concat()).is_none());
        assert!(parse(b"Pf\n1 1\n-1.0\n0000").is_none());
        let big = parse(b"PF 1 1 1.0\n\x3f\x80\0\0\x40\0\0\0\0\0\0\0").unwrap();
        assert_eq!(big.pixels(), [[1.0, 2.0, 0.0]]);
        assert!(matches!(read(folder.path().join("none")), Err(ReadError::Io { .. })));
    }
}
