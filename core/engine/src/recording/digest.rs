//! A 64-bit digest for comparing states and files.

use crate::session::Session;
use pliant_mesh::read::{MODEL_LIMIT, read_file};
use std::io;
use std::path::Path;

/// Digest of a sequence of 64-bit words. Each step is a bijection of the word and of the previous digest, so two sequences of one length that
/// differ in one word have different digests; others agree by chance in one case of 2^64. It does not protect against forgery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0x9e37_79b9_7f4a_7c15)
    }
}

impl Digest {
    /// Adds one word.
    pub fn word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0xd6e8_feb8_6659_fd93).rotate_left(32);
    }

    /// Adds numbers by their bits.
    pub fn numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|number| self.word(number.to_bits()));
    }

    /// Adds bytes and their count.
    pub fn bytes(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.word(u64::from_le_bytes(*word)));
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.word(u64::from_le_bytes(last));
        self.word(bytes.len() as u64);
    }

    /// Digest of bytes.
    pub fn of(bytes: &[u8]) -> u64 {
        let mut digest = Self::default();
        digest.bytes(bytes);
        digest.value()
    }

    /// Digest of the bytes of a regular file.
    ///
    /// # Errors
    /// The error of the file system, without the path.
    pub fn of_file(path: &Path) -> io::Result<u64> {
        Ok(Self::of(&read_file(path, MODEL_LIMIT)?))
    }

    /// The digest of the words added so far.
    pub fn value(self) -> u64 {
        self.0 ^ (self.0 >> 29)
    }
}

/// Digest of the state of a session: positions and velocities of the nodes of all bodies, proxies and forces of all tools.
pub fn state_digest(session: &Session) -> u64 {
    let mut digest = Digest::default();
    for body in &session.bodies {
        let nodes = &body.system.nodes;
        digest.word(nodes.len() as u64);
        nodes.x.iter().chain(&nodes.v).for_each(|of_node| digest.numbers(of_node.as_slice()));
    }
    for tool in &session.frame().tools {
        digest.numbers(tool.proxy.as_slice());
        digest.numbers(tool.force.as_slice());
    }
    digest.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_single_bit_counts() {
        let bytes: Vec<u8> = (0..61).collect();
        let whole = Digest::of(&bytes);
        for bit in 0..8 * bytes.len() {
            let mut other = bytes.clone();
            other[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(Digest::of(&other), whole, "bit {bit}");
        }
        assert_ne!(Digest::of(&bytes[..60]), whole);
        assert_ne!(Digest::of(&[0; 8]), Digest::of(&[0; 9]));
    }
}
