//! A stream of text as blocks of whole lines, read on a thread of its own.
//!
//! A block is what one read gave, up to its last line end: large when there is much to read, and one
//! line when a program hands its rays over one by one and waits for the answer.

use std::{
    io::{self, Read},
    sync::mpsc::{Receiver, sync_channel},
    thread,
};

/// How much is read at once: enough rays to keep a core busy for about a millisecond.
const BLOCK: usize = 64 << 10;

/// No row of numbers is longer than this; a file without line ends is something else.
pub(crate) const LONGEST_LINE: usize = 1 << 20;

/// Why there is no next block.
#[derive(Debug)]
pub(crate) enum ReadError {
    Io(io::Error),
    /// A line is longer than [`LONGEST_LINE`].
    LongLine,
}

/// Cuts what `input` gives into blocks of whole lines; only the last may lack its line end.
#[derive(Debug)]
struct Blocks<R> {
    input: R,
    /// The beginning of a line whose end has not been read.
    rest: Vec<u8>,
}

impl<R: Read> Blocks<R> {
    fn next(&mut self) -> Result<Option<Vec<u8>>, ReadError> {
        let mut block = std::mem::take(&mut self.rest);
        loop {
            let known = block.len();
            block.resize(known + BLOCK, 0);
            let read = loop {
                match self.input.read(&mut block[known..]) {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    other => break other.map_err(ReadError::Io)?,
                }
            };
            block.truncate(known + read);
            if read == 0 {
                return Ok(if block.is_empty() { None } else { Some(block) });
            }
            if let Some(end) = block[known..].iter().rposition(|&b| b == b'\n') {
                self.rest = block.split_off(known + end + 1);
                return Ok(Some(block));
            }
            if block.len() > LONGEST_LINE {
                return Err(ReadError::LongLine);
            }
        }
    }
}

/// Reads `input` on a thread of its own, at most `ahead` blocks ahead of whoever receives them.
/// The thread ends with the input or, at its next block, after the receiver is gone.
pub(crate) fn read_ahead(
    input: Box<dyn Read + Send>,
    ahead: usize,
) -> Receiver<Result<Vec<u8>, ReadError>> {
    let (sender, receiver) = sync_channel(ahead);
    thread::spawn(move || {
        let mut blocks = Blocks { input, rest: Vec::new() };
        while let Some(block) = blocks.next().transpose() {
            let last = block.is_err();
            if sender.send(block).is_err() || last {
                break;
            }
        }
    });
    receiver
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives a few bytes at a time.
    struct Dribble<'a>(&'a [u8], usize);

    impl Read for Dribble<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let n = self.1.min(self.0.len()).min(buffer.len());
            buffer[..n].copy_from_slice(&self.0[..n]);
            self.0 = &self.0[n..];
            Ok(n)
        }
    }

    #[test]
    fn blocks_are_whole_lines_however_they_arrive() {
        let text = b"one\ntwo\n\nthree,3\r\nlast";
        for step in 1..=text.len() {
            let mut blocks = Blocks { input: Dribble(text, step), rest: Vec::new() };
            let mut all = Vec::new();
            while let Some(block) = blocks.next().unwrap() {
                assert!(block.ends_with(b"\n") || all.len() + block.len() == text.len());
                all.extend(block);
            }
            assert_eq!(all, text);
        }
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let mut blocks = Blocks { input: io::repeat(b'1'), rest: Vec::new() };
        assert!(matches!(blocks.next(), Err(ReadError::LongLine)));
    }
}
